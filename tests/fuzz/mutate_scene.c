// How libFuzzer damages glTF: every other time by the values of its JSON, with lengths that are right again.
#include "mutate.h"
#include "target.h"

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    struct ng_rng rng = ng_rng_make(seed, 1);
    struct bytes b = {0};
    if (size < 4 || fuzz_one_in(&rng, 2))
        return LLVMFuzzerMutate(data, size, most);
    bytes_splice(&b, 0, 0, data, size);
    if (memcmp(data, "glTF", 4) == 0)
        mutate_glb(&b, &rng);
    else
        mutate_text(&b, &rng);
    size = b.data.count < most ? b.data.count : most;
    memcpy(data, b.data.items, size);
    ng_array_finish(&b.data);
    return size;
}
