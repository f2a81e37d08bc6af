/* Dhrystone's side of the model: what it asks of a library. It counts between its two calls of `time`. */
#include <stddef.h>

extern int Int_Glob, Bool_Glob, Arr_2_Glob[50][50];
extern char Ch_1_Glob;

__attribute__((noinline)) long time(void *now) {
    (void)now;
    __asm volatile("");
    return 0;
}

int scanf(const char *format, int *runs) {
    (void)format;
    *runs = RUNS;
    return 1;
}

int printf(const char *format, ...) {
    (void)format;
    return 0;
}

void *malloc(size_t bytes) {
    static char memory[256];
    static size_t used;
    size_t at = used;
    used = (at + bytes + 7) & ~(size_t)7;
    return memory + at;
}

/* The values that the program prints as those that should be. */
int is_right(void) {
    return Int_Glob == 5 && Bool_Glob == 1 && Ch_1_Glob == 'A' && Arr_2_Glob[8][7] == RUNS + 10;
}
