//! The side that faces QEMU: its C interface, and the three calls it makes.
//!
//! QEMU calls [`qemu_plugin_install`] once, `translated` for every block of code it
//! translates, `executed` for every instruction, and `finished` at the end. The functions
//! used here are the same in all versions of the interface so far; only the version
//! number differs, and the build sets it through `M4_CYCLES_API`.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use crate::arguments::Arguments;
use crate::report;
use crate::trace::{Site, Trace};

/// Version of QEMU's plugin interface: 1 for QEMU before 9.0, such as Debian 12's 7.2.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = match option_env!("M4_CYCLES_API") {
    Some(version) => (version.as_bytes()[0] - b'0') as c_int,
    None => 1,
};

/// "The callback touches no register", in `enum qemu_plugin_cb_flags`.
const NO_REGISTERS: c_int = 0;

/// Translated block, known to QEMU only.
type Block = c_void;
/// Instruction of a block, known to QEMU only.
type Insn = c_void;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: extern "C" fn(u64, *mut Block));
    fn qemu_plugin_register_atexit_cb(
        id: u64,
        callback: extern "C" fn(u64, *mut c_void),
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        insn: *mut Insn,
        callback: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut Insn;
    fn qemu_plugin_insn_disas(insn: *const Insn) -> *mut c_char;
    fn qemu_plugin_insn_vaddr(insn: *const Insn) -> u64;
    fn qemu_plugin_insn_size(insn: *const Insn) -> usize;
}

struct State {
    trace: Trace,
    out: PathBuf,
}

static STATE: OnceLock<State> = OnceLock::new();

/// Entry point: reads the arguments and asks to be called.
///
/// # Safety
/// Only QEMU calls this, with `argc` C strings in `argv`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let words: Vec<_> = (0..usize::try_from(argc).unwrap_or(0))
        // SAFETY: QEMU passes `argc` pointers to strings that live during this call.
        .map(|index| unsafe { CStr::from_ptr(*argv.add(index)) }.to_string_lossy())
        .collect();
    let arguments = match Arguments::parse(words.iter().map(|word| &**word)) {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!("m4-cycles: {why}");
            return 1;
        }
    };
    STATE.get_or_init(|| State {
        trace: Trace::new(arguments.begin, arguments.end),
        out: arguments.out,
    });
    // SAFETY: `id` is the one QEMU gave us; the callbacks have the types it asks for.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
        qemu_plugin_register_atexit_cb(id, finished, std::ptr::null_mut());
    }
    0
}

/// A block was translated: finds or makes the site of each instruction.
extern "C" fn translated(_id: u64, block: *mut Block) {
    let Some(state) = STATE.get() else { return };
    // SAFETY: `block` is valid during this call.
    let count = unsafe { qemu_plugin_tb_n_insns(block) };
    for index in 0..count {
        // SAFETY: `index` is below the count; the instruction lives as long as the block.
        let (insn, address) = unsafe {
            let insn = qemu_plugin_tb_get_insn(block, index);
            (insn, qemu_plugin_insn_vaddr(insn))
        };
        let site = state.trace.site(address, || {
            // SAFETY: as above.
            unsafe {
                Site::new(
                    address,
                    qemu_plugin_insn_size(insn) as u64,
                    disassembly(insn),
                )
            }
        });
        let data = std::ptr::from_ref(site).cast_mut().cast();
        // SAFETY: `data` points to a site that lives as long as the process.
        unsafe { qemu_plugin_register_vcpu_insn_exec_cb(insn, executed, NO_REGISTERS, data) };
    }
}

/// QEMU's disassembly of an instruction; empty when it has none.
///
/// # Safety
/// `insn` must be an instruction of the block being translated.
unsafe fn disassembly(insn: *const Insn) -> String {
    // SAFETY: the caller's promise. The string is QEMU's allocation and leaks: there is
    // one per instruction of the image.
    unsafe {
        let line = qemu_plugin_insn_disas(insn);
        if line.is_null() {
            String::new()
        } else {
            CStr::from_ptr(line).to_string_lossy().into_owned()
        }
    }
}

extern "C" fn executed(_cpu: c_uint, data: *mut c_void) {
    // SAFETY: `data` is the site that `translated` registered with this instruction.
    let site: &'static Site = unsafe { &*data.cast::<Site>() };
    if let Some(state) = STATE.get() {
        state.trace.execute(site);
    }
}

extern "C" fn finished(_id: u64, _data: *mut c_void) {
    let Some(state) = STATE.get() else { return };
    if let Err(why) = fs::write(&state.out, report::text(&state.trace.sites())) {
        eprintln!("m4-cycles: cannot write {}: {why}", state.out.display());
    }
}
