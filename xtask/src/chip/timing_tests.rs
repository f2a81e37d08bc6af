//! Cycles of short programs, by the tables of the manual.

use super::program::Program;
use super::timing::{Form, Setup, Taken, run};
use super::trace::{Step, Trace};

const AT: u32 = 0x0800_0000;
const COUPLED: u32 = 0x1000_0000;

fn taken(from: u32, halfwords: &[u16], order: &[u32], setup: Setup) -> Taken {
    let program = Program::of_halfwords(from, halfwords);
    let steps = order.iter().map(|at| Step::Run(from + at)).collect();
    let trace = Trace {
        steps,
        masked: false,
    };
    run(&program, &trace, setup)
}

fn flash(bytes: u32, times: u32, prefetch: bool) -> Taken {
    let nops = vec![0xBF00; bytes as usize / 2];
    let once = (0..bytes / 2).map(|n| 2 * n);
    let order: Vec<u32> = (0..times).flat_map(|_| once.clone()).collect();
    let setup = Setup {
        prefetch,
        form: Form::Least,
    };
    taken(AT, &nops, &order, setup)
}

/// Four instructions a read: each read waits four cycles; with prefetch the next one is on its
/// way meanwhile, and one cycle is left to wait.
#[test]
fn a_straight_line_waits_for_every_read() {
    let bare = flash(8 * 100, 1, false);
    assert_eq!((bare.instructions, bare.waited), (400, 400));
    let ahead = flash(8 * 100, 1, true);
    assert_eq!(ahead.waited, 4 + 99);
    assert_eq!(ahead.cycles, 400 + 103);
}

/// What fits the cache waits once; one line more than fits, used in turn, always.
#[test]
fn a_loop_that_fits_the_cache_waits_once() {
    assert_eq!(flash(1024, 50, false).waited, 4 * 128);
    assert_eq!(flash(1024 + 32, 50, false).waited, 4 * 132 * 50);
}

/// Cycles in the coupled memory, which never waits: at the least, at the most.
fn both(halfwords: &[u16], order: &[u32]) -> (u64, u64) {
    let of = |form| {
        let setup = Setup {
            prefetch: true,
            form,
        };
        let taken = taken(COUPLED, halfwords, order, setup);
        assert_eq!(taken.waited, 0);
        taken.cycles
    };
    (of(Form::Least), of(Form::Most))
}

#[test]
fn loads_in_a_row_overlap_unless_one_gives_the_address_of_the_next() {
    // ldr r0, [r1]; ldr r2, [r3]
    assert_eq!(both(&[0x6808, 0x681A], &[0, 2]), (3, 4));
    // ldr r0, [r1]; ldr r2, [r0]
    assert_eq!(both(&[0x6808, 0x6802], &[0, 2]), (4, 4));
    // str r0, [r1]; str r0, [r1]
    assert_eq!(both(&[0x6008, 0x6008], &[0, 2]), (2, 4));
    // push {r4, lr}
    assert_eq!(both(&[0xB510], &[0]), (3, 3));
}

#[test]
fn a_jump_refills_the_pipeline_where_it_is_taken() {
    // bne back; nop
    assert_eq!(both(&[0xD1FD, 0xBF00], &[0, 2]), (2, 2));
    assert_eq!(both(&[0xD1FD, 0xBF00], &[0, 0]), (3, 5));
}

#[test]
fn a_result_of_the_floating_point_unit_is_a_cycle_late() {
    // vadd.f32 s3, s3, s0 twice; vfma.f32 s0, s1, s2 twice
    assert_eq!(both(&[0xEE71, 0x1A80, 0xEE71, 0x1A80], &[0, 4]), (3, 3));
    assert_eq!(both(&[0xEEA0, 0x0A81, 0xEEA0, 0x0A81], &[0, 4]), (6, 7));
}

#[test]
fn a_division_goes_on_beside_what_does_not_need_the_unit() {
    // vdiv.f32 s0, s1, s2; nop
    assert_eq!(both(&[0xEE80, 0x0A81, 0xBF00], &[0, 4]), (2, 15));
    // vdiv.f32 s0, s1, s2; vadd.f32 s3, s3, s0
    assert_eq!(both(&[0xEE80, 0x0A81, 0xEE71, 0x1A80], &[0, 4]), (15, 16));
    // udiv r0, r0, r1
    assert_eq!(both(&[0xFBB0, 0xF0F1], &[0]), (2, 12));
}

#[test]
fn exceptions_take_their_time_and_keep_the_registers_that_they_use() {
    // nop; vadd.f32 s3, s3, s0
    let program = Program::of_halfwords(COUPLED, &[0xBF00, 0xEE71, 0x1A80]);
    let enter = Step::Enter { number: 28, at: 0 };
    let of = |steps: &[Step]| {
        let trace = Trace {
            steps: steps.to_vec(),
            masked: false,
        };
        let setup = Setup {
            prefetch: true,
            form: Form::Least,
        };
        run(&program, &trace, setup)
    };
    let bare = of(&[enter, Step::Run(COUPLED), Step::Leave]);
    assert_eq!((bare.cycles, bare.exceptions), (12 + 1 + 10, 22));
    let float = of(&[enter, Step::Run(COUPLED + 2), Step::Leave]);
    assert_eq!((float.cycles, float.exceptions), (12 + 17 + 1 + 27, 56));
    // Where the program was is known again after it: no jump.
    let around = of(&[
        Step::Run(COUPLED),
        enter,
        Step::Run(COUPLED),
        Step::Leave,
        Step::Run(COUPLED + 2),
    ]);
    assert_eq!(around.cycles, 1 + 23 + 1);
}

/// The caches of instructions and of data are apart; the flash ends the read of the one before
/// it begins that of the other.
#[test]
fn data_in_the_flash_wait_too() {
    let program = Program::of_halfwords(AT, &[0x4801, 0xBF00]);
    let steps = [Step::Run(AT), Step::Load(AT + 8)].repeat(2);
    let trace = Trace {
        steps,
        masked: false,
    };
    let setup = Setup {
        prefetch: false,
        form: Form::Most,
    };
    let seen = run(&program, &trace, setup);
    assert_eq!((seen.waited, seen.waited_for_data), (4, 4));
}
