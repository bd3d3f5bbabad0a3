// The suballocator against a plain list of what is live, and device memory as a whole.
#include "gpu_test.h"

#include "base/rng.h"
#include "gpu/buffer.h"
#include "gpu/suballocator.h"

struct range {
    uint64_t offset, size;
};

static void check_free_ranges(const struct ng_suballocator *s, const struct range *live, size_t count)
{
    uint64_t total = 0;
    for (size_t i = 0; i < s->free.count; i++) {
        struct ng_gpu_range f = s->free.items[i];
        total += f.size;
        assert_true(f.size > 0);
        // Sorted, and never two neighbours that should be one.
        if (i)
            assert_true(s->free.items[i - 1].offset + s->free.items[i - 1].size < f.offset);
    }
    for (size_t i = 0; i < count; i++)
        total += live[i].size;
    assert_int_equal(total, s->size);
}

static bool overlaps(struct range a, struct range b)
{
    return a.offset < b.offset + b.size && b.offset < a.offset + a.size;
}

static void test_suballocator_random(void **state)
{
    NG_UNUSED(state);
    enum { MAX_LIVE = 200, STEPS = 3000 };
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct ng_rng rng = ng_rng_make(seed, 0);
        struct ng_suballocator s;
        struct range live[MAX_LIVE];
        size_t count = 0;
        assert_true(ng_suballocator_init(&s, 1 << 16));
        for (int step = 0; step < STEPS; step++) {
            if (count == MAX_LIVE || (count && ng_rng_below(&rng, 5) < 2)) {
                size_t i = ng_rng_below(&rng, (uint32_t)count);
                ng_suballocator_free(&s, live[i].offset, live[i].size);
                live[i] = live[--count];
            } else {
                uint64_t size = 1 + ng_rng_below(&rng, 2000), alignment = 1u << ng_rng_below(&rng, 9);
                uint64_t offset = ng_suballocator_allocate(&s, size, alignment);
                if (offset == NG_SUBALLOCATOR_FULL)
                    continue;
                struct range r = {offset, size};
                assert_int_equal(offset % alignment, 0);
                assert_true(offset + size <= s.size);
                for (size_t i = 0; i < count; i++)
                    assert_false(overlaps(live[i], r));
                live[count++] = r;
            }
            check_free_ranges(&s, live, count);
        }
        while (count--)
            ng_suballocator_free(&s, live[count].offset, live[count].size);
        // All of it in one piece again.
        assert_int_equal(s.free.count, 1);
        assert_int_equal(ng_suballocator_allocate(&s, 1 << 16, 1), 0);
        ng_suballocator_finish(&s);
    }
}

static void test_suballocator_alignment(void **state)
{
    NG_UNUSED(state);
    struct ng_suballocator s;
    assert_true(ng_suballocator_init(&s, 100));
    assert_int_equal(ng_suballocator_allocate(&s, 10, 1), 0);
    assert_int_equal(ng_suballocator_allocate(&s, 10, 64), 64);
    assert_int_equal(ng_suballocator_allocate(&s, 54, 1), 10); // the padding is not lost
    assert_int_equal(ng_suballocator_allocate(&s, 27, 1), NG_SUBALLOCATOR_FULL);
    assert_int_equal(ng_suballocator_allocate(&s, UINT64_MAX, 1), NG_SUBALLOCATOR_FULL);
    assert_int_equal(ng_suballocator_allocate(&s, 26, 1), 74);
    ng_suballocator_finish(&s);
}

static struct ng_gpu_buffer *make(struct ng_gpu *gpu, const char *name, uint64_t size,
                                  enum ng_gpu_memory_kind kind)
{
    struct ng_gpu_buffer *b;
    assert_int_equal(ng_gpu_buffer_create(
                         gpu, &(struct ng_gpu_buffer_params){.name = name, .size = size, .memory = kind}, &b),
                     NG_OK);
    return b;
}

static void test_device_memory(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    uint64_t used = ng_gpu_stats(gpu).memory_used;
    struct ng_gpu_buffer *small[40], *huge = make(gpu, "huge", 200 << 20, NG_GPU_MEMORY_DEVICE);
    for (size_t i = 0; i < NG_COUNT(small); i++)
        small[i] = make(gpu, "small", 1000 + i, i % 2 ? NG_GPU_MEMORY_UPLOAD : NG_GPU_MEMORY_READBACK);
    struct ng_gpu_stats s = ng_gpu_stats(gpu);
    assert_true(s.memory_used - used >= (200 << 20) + 40 * 1000);
    assert_true(s.memory_blocks < 8); // forty small ones share
    assert_true(s.memory_budget >= s.memory_reserved && s.memory_peak >= s.memory_reserved);
    for (size_t i = 0; i < NG_COUNT(small); i++)
        memset(small[i]->mapped, (int)i, small[i]->size);
    for (size_t i = 0; i < NG_COUNT(small); i++) { // nobody wrote into a neighbour
        const unsigned char *bytes = small[i]->mapped;
        assert_int_equal(bytes[0], i);
        assert_int_equal(bytes[small[i]->size - 1], i);
    }
    for (size_t i = 0; i < NG_COUNT(small); i++)
        ng_gpu_buffer_destroy(&small[i]);
    ng_gpu_buffer_destroy(&huge);
    assert_null(huge);
    s = ng_gpu_stats(gpu);
    assert_int_equal(s.memory_used, used);
    assert_true(s.memory_reserved < (200 << 20)); // the huge one went back to the driver
    gpu_test_end(gpu);
}

static void test_alignment_is_kept(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_memory odd, aligned;
    VkMemoryRequirements need = {.size = 3, .alignment = 1, .memoryTypeBits = UINT32_MAX};
    assert_int_equal(ng_gpu_memory_allocate(gpu, &need, NG_GPU_MEMORY_UPLOAD, "odd", &odd), NG_OK);
    need.alignment = 1 << 16;
    assert_int_equal(ng_gpu_memory_allocate(gpu, &need, NG_GPU_MEMORY_UPLOAD, "aligned", &aligned), NG_OK);
    assert_true(aligned.memory == odd.memory && aligned.offset != odd.offset);
    assert_int_equal(aligned.offset % (1 << 16), 0);
    assert_true((unsigned char *)aligned.mapped - aligned.offset == (unsigned char *)odd.mapped - odd.offset);
    ng_gpu_memory_free(gpu, &odd);
    ng_gpu_memory_free(gpu, &aligned);
    ng_gpu_memory_free(gpu, &aligned); // zero by now
    gpu_test_end(gpu);
}

static void test_placed_objects_share(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer_params params = {.name = "first", .size = 4096};
    VkMemoryRequirements need;
    struct ng_gpu_memory memory;
    assert_int_equal(ng_gpu_buffer_requirements(gpu, &params, &need), NG_OK);
    assert_true(need.size >= 4096);
    assert_int_equal(ng_gpu_memory_allocate(gpu, &need, NG_GPU_MEMORY_UPLOAD, "shared", &memory), NG_OK);
    struct ng_gpu_buffer *a, *b;
    params.place = &memory;
    assert_int_equal(ng_gpu_buffer_create(gpu, &params, &a), NG_OK);
    params.name = "second";
    assert_int_equal(ng_gpu_buffer_create(gpu, &params, &b), NG_OK);
    memset(a->mapped, 7, 4096);
    assert_int_equal(((unsigned char *)b->mapped)[4095], 7);
    // Not where it does not fit.
    struct test_log log;
    struct ng_gpu_buffer *c;
    params.place_offset = need.alignment;
    test_log_begin(&log);
    assert_int_equal(ng_gpu_buffer_create(gpu, &params, &c), NG_ERROR_USAGE);
    test_log_end(&log);
    assert_null(c);
    assert_non_null(strstr(log.text, "second"));
    ng_gpu_buffer_destroy(&a);
    ng_gpu_buffer_destroy(&b);
    ng_gpu_memory_free(gpu, &memory);
    assert_null(memory.block);
    gpu_test_end(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_suballocator_random),  cmocka_unit_test(test_suballocator_alignment),
        cmocka_unit_test(test_device_memory),        cmocka_unit_test(test_alignment_is_kept),
        cmocka_unit_test(test_placed_objects_share),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
