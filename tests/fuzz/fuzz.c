#include "fuzz.h"

struct fuzz fuzz = {.rounds = 1000, .seed = 1};

void fuzz_arguments(int argc, char **argv)
{
    uint32_t *values[] = {&fuzz.rounds, &fuzz.seed, &fuzz.first};
    for (int i = 1; i < argc && i <= (int)NG_COUNT(values); i++)
        *values[i - 1] = (uint32_t)strtoul(argv[i], NULL, 10);
}

struct ng_rng fuzz_round(uint32_t round)
{
    static FILE *file;
    char path[512];
    test_path(path, sizeof path, "round");
    if (!file)
        file = fopen(path, "w");
    assert_non_null(file);
    rewind(file);
    fprintf(file, "1 %u %u        \n", fuzz.seed, round); // the arguments that repeat it
    fflush(file);
    return ng_rng_make(fuzz.seed, round);
}
