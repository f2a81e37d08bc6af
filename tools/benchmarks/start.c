/* Start and end of a benchmark on the model of an STM32G474: a reset ends the run, an instruction that
   there is not ends it as a failure. */
#include <stdint.h>

extern uint32_t code_from[], code_to[], code_end[], data_from[], data_to[], data_end[], bss_end[];
int main();
/* Whether the benchmark's own check of its results says so. */
int is_right(void);

/* The library's copy is not there yet. */
#pragma GCC optimize("no-tree-loop-distribute-patterns")

__attribute__((always_inline)) static inline void copy(const uint32_t *from, uint32_t *to, const uint32_t *end) {
    if (from == to) return;
    while (to < end) *to++ = *from++;
}

__attribute__((section(".first"), noreturn)) void reset(void) {
    copy(code_from, code_to, code_end);
    copy(data_from, data_to, data_end);
    for (uint32_t *at = data_end; at < bss_end; at++) *at = 0;
    main();
    if (!is_right()) __asm volatile("udf #0");
    *(volatile uint32_t *)0xE000ED0C = 0x05FA0004;
    for (;;) {}
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    0x20018000,
    (uintptr_t)reset,
};
