"""The flash's check bits and its programming; the supply's monitor."""

FLASH, BANK_BYTES, PAGE_BYTES = 0x0800_0000, 0x4_0000, 0x800
FLASH_SR, FLASH_CR, FLASH_ECCR = 0x4002_2010, 0x4002_2014, 0x4002_2018
PWR_CR2, PWR_SR2 = 0x4000_7004, 0x4000_7014
SYSCFG_CFGR2 = 0x4001_001C
EXTI_IMR1, EXTI_RTSR1, EXTI_PR1 = 0x4001_0400, 0x4001_0408, 0x4001_0414
FLASH_KEYR, KEYS, LOCKED = 0x4002_2008, (0x4567_0123, 0xCDEF_89AB), 1 << 31
PROGRAM, PAGE_ERASE, BANK_2, START = 1, 2, 1 << 11, 1 << 16
# A page takes 22 ms in the mean, a double word some 80 us; rounded up, in ticks.
ERASE_TICKS, PROGRAM_TICKS = round(25e-3 * 163.2e6), round(100e-6 * 163.2e6)
DOUBLE_ERROR, FLAGS = 1 << 31, 0xF000_0000
ECC_LOCK, PVD_LOCK = 1 << 3, 1 << 2
PVD_LINE, INTERRUPT_PVD = 1 << 16, 1
NMI = 2
NEVER = 1 << 62


class FlashMemory:
    """Erased by pages, programmed through its control register, with words that are spoilt."""

    def __init__(self, bus):
        self.bus = bus
        self.spoilt = set()
        self.held_at = None
        self.busy_until = 0
        self.keys = ()

    def spoil(self, address):
        """The double word at an address has two bits wrong from now on."""
        address &= ~7
        if address not in self.spoilt:
            self.spoilt.add(address)
            self.bus.core.on_read(address, 8, self._read_spoilt)

    def _read_spoilt(self, address):
        if address & ~7 not in self.spoilt:
            return
        if address == self.held_at:
            # The load that was stopped for the exception is executed once more.
            self.held_at = None
            return
        self.held_at = address
        self.fail(address & ~7)
        self.bus.core.uc.emu_stop()

    def fail(self, address):
        """A load, or a fetch, finds a double error there."""
        bus, offset = self.bus, address - FLASH
        bank = int(offset >= BANK_BYTES) << 21
        bus.register[FLASH_ECCR] = DOUBLE_ERROR | bank | offset % BANK_BYTES
        bus.exception = NMI
        if bus.stored(SYSCFG_CFGR2) & ECC_LOCK:
            bus.power.system_break()

    def may_program(self):
        """Whether a store to the flash is taken."""
        return self.bus.stored(FLASH_CR) & (PROGRAM | LOCKED) == PROGRAM

    def programmed(self, address):
        """A word was stored: the second one of a pair starts the programming of both."""
        if address & 4:
            self.busy_until = self.bus.now + PROGRAM_TICKS

    def read(self, address):
        if address == FLASH_SR and self.bus.now < self.busy_until:
            # Whoever waits waits to the end, and no interrupt is served meanwhile: handlers
            # lie in the same bank, as far as anybody knows.
            self.bus.passing(self.busy_until - self.bus.now)

    def write(self, address, value):
        if address == FLASH_ECCR:
            old = self.bus.stored(address)
            self.bus.register[address] = old & ~(value & FLAGS)
            return True
        if address == FLASH_KEYR:
            self.keys = (*self.keys, value)[-2:]
            if self.keys == KEYS:
                self.bus.register[FLASH_CR] = self.bus.stored(FLASH_CR) & ~LOCKED
            return True
        if address == FLASH_CR and self.bus.stored(FLASH_CR) & LOCKED:
            if value ^ self.bus.stored(FLASH_CR):
                self.bus.judge.find("is locked", "FLASH.CR")
            return True
        if address == FLASH_CR and value & START:
            if value & PAGE_ERASE:
                page = (value >> 3 & 0x7F) * PAGE_BYTES + (BANK_BYTES if value & BANK_2 else 0)
                self.bus.core.uc.mem_write(FLASH + page, b"\xff" * PAGE_BYTES)
                self.spoilt -= set(range(FLASH + page, FLASH + page + PAGE_BYTES, 8))
                self.busy_until = self.bus.now + ERASE_TICKS
                self.bus.note("erase", hex(FLASH + page), 1)
            self.bus.register[address] = value & ~START
            return True
        return False

    def put_back(self, addresses):
        pass

    def next_event(self):
        return NEVER

    def happen(self):
        pass

    def interrupts(self):
        return set()


class Supply:
    """Falls below the monitor's threshold and comes back when the script says so."""

    def __init__(self, bus):
        self.bus = bus
        self.low = False
        self.requested = False

    def set(self, low):
        """The supply crosses the threshold."""
        bus = self.bus
        on = bus.stored(PWR_CR2) & 1
        if low and not self.low and on:
            self.requested |= bool(bus.stored(EXTI_RTSR1) & PVD_LINE)
            if bus.stored(SYSCFG_CFGR2) & PVD_LOCK:
                bus.power.system_break()
        self.low = low

    def read(self, address):
        if address == PWR_SR2:
            return int(self.low and self.bus.stored(PWR_CR2) & 1) << 11
        if address == EXTI_PR1:
            return PVD_LINE if self.requested else 0
        return None

    def write(self, address, value):
        if address == EXTI_PR1:
            self.requested &= not value & PVD_LINE
            return True
        return False

    def put_back(self, addresses):
        pass

    def next_event(self):
        return NEVER

    def happen(self):
        pass

    def interrupts(self):
        wanted = self.requested and self.bus.stored(EXTI_IMR1) & PVD_LINE
        return {INTERRUPT_PVD} if wanted else set()
