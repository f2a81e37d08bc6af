//! The block of the tests is written by hand, word by word after the data sheet's least block for ARM.

use super::*;

const LEAST: [u32; 5] = [
    0xFFFF_DED3, // begin
    0x1021_0142, // image type, one word long: executable, ARM, secure, RP2350
    0x0000_01FF, // last item: one word of items
    0x0000_0000, // the next block: this one
    0xAB12_3579, // end
];

fn image(vectors: [u32; 2], at: usize, block: &[u32]) -> Vec<u8> {
    let mut words = vec![0xFFFF_FFFFu32; 2048];
    words[..2].copy_from_slice(&vectors);
    words[at / 4..at / 4 + block.len()].copy_from_slice(block);
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

const VECTORS: [u32; 2] = [0x2008_2000, 0x1000_0129];

#[test]
fn the_least_block_is_taken_where_the_rom_looks() {
    for at in [8, 0x114, 4096 - 20] {
        assert_eq!(check(&image(VECTORS, at, &LEAST)), Ok(at));
    }
    let late = check(&image(VECTORS, 4096, &LEAST));
    assert!(late.is_err_and(|why| why.contains("4 KB")));
    assert!(check(&[]).is_err());
}

#[test]
fn every_word_of_the_block_matters() {
    let wrong = [
        (0, 0xFFFF_DED4, "no block"),
        (1, 0x1121_0142, "0x1121"), // RISC-V
        (1, 0x1011_0142, "0x1011"), // not secure
        (1, 0x0021_0142, "0x0021"), // RP2040
        (1, 0x9021_0142, "0x9021"), // to be bought first
        (1, 0x1022_0142, "0x1022"), // data
        (1, 0x1021_0242, "too early|not known"),
        (1, 0x1021_0042, "length"),
        (2, 0x0000_02FF, "words"),
        (3, 0x0000_0010, "itself"),
        (4, 0xAB12_3578, "marker"),
    ];
    for (place, word, said) in wrong {
        let mut block = LEAST;
        block[place] = word;
        let why = check(&image(VECTORS, 0x114, &block)).expect_err("wrong");
        assert!(said.split('|').any(|part| why.contains(part)), "{why}");
    }
}

#[test]
fn vectors_lead_into_ram_and_flash() {
    for (vectors, said) in [
        ([0x2008_2008, VECTORS[1]], "stack"),
        ([0x1000_2000, VECTORS[1]], "stack"),
        ([0x2000_0004, VECTORS[1]], "stack"),
        ([VECTORS[0], 0x1000_0128], "first instruction"),
        ([VECTORS[0], 0x2000_0129], "first instruction"),
    ] {
        let why = check(&image(vectors, 0x114, &LEAST)).expect_err("wrong");
        assert!(why.contains(said), "{why}");
    }
}

/// Read back by the words of the format: 512-byte blocks, numbered, each with its address and family.
#[test]
fn a_uf2_holds_every_page_once_and_in_order() {
    let flash: Vec<u8> = (0..700u32).map(|n| (n % 251) as u8).collect();
    let file = uf2(&flash);
    assert_eq!(file.len(), 3 * 512);
    let mut back: Vec<u8> = Vec::new();
    for (n, block) in file.chunks(512).enumerate() {
        let words: Vec<u32> = block[..32]
            .chunks(4)
            .map(|b| u32::from_le_bytes(b.try_into().expect("four")))
            .collect();
        assert_eq!(&block[..4], b"UF2\n");
        assert_eq!(words[1], 0x9E5D_5157);
        assert_eq!(words[2] & 0x2000, 0x2000);
        assert_eq!(words[3], 0x1000_0000 + 256 * n as u32);
        assert_eq!((words[4], words[5], words[6]), (256, n as u32, 3));
        assert_eq!(words[7], 0xE48B_FF59);
        assert_eq!(&block[508..], [0x30, 0x6F, 0xB1, 0x0A]);
        back.extend(&block[32..288]);
    }
    assert_eq!(back[..700], flash);
    assert!(back[700..].iter().all(|byte| *byte == 0xFF));
}
