// The base library: what the rest of the engine relies on without looking.
#include "test.h"

#include "base/arena.h"
#include "base/array.h"
#include "base/file.h"
#include "base/half.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/pool.h"
#include "base/printable.h"
#include "base/rng.h"
#include "base/system.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void arena_reuses_its_blocks(void **state)
{
    NG_UNUSED(state);
    struct ng_arena a = {0};
    for (int round = 0; round < 3; round++) {
        struct ng_arena_block *first = a.first;
        for (size_t i = 1; i < 2000; i++) {
            unsigned char *p = ng_arena_alloc(&a, i);
            assert_non_null(p);
            assert_int_equal((uintptr_t)p % 16, 0);
            for (size_t k = 0; k < i; k++)
                assert_int_equal(p[k], 0);
            memset(p, 0xff, i);
        }
        if (round)
            assert_ptr_equal(a.first, first);
        ng_arena_reset(&a);
    }
    assert_null(ng_arena_array(&a, SIZE_MAX / 2, 4));
    a.limit = 64;
    assert_non_null(ng_arena_alloc(&a, 64));
    assert_null(ng_arena_alloc(&a, 1));
    ng_arena_finish(&a);
}

static void out_of_memory_is_one_line(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_out_of_memory("a 50% scene"), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "out of memory: a 50% scene"));
}

static void pool_finds_stale_handles(void **state)
{
    NG_UNUSED(state);
    struct ng_pool p = {0};
    uint32_t a = ng_pool_acquire(&p), b = ng_pool_acquire(&p);
    assert_true(ng_pool_has(&p, a) && ng_pool_has(&p, b) && a != b);
    assert_true(ng_pool_release(&p, a));
    assert_false(ng_pool_release(&p, a));
    uint32_t c = ng_pool_acquire(&p);
    assert_int_equal(ng_pool_slot(c), ng_pool_slot(a));
    assert_false(ng_pool_has(&p, a));
    assert_true(ng_pool_has(&p, c));
    // No handle is ever given twice, even after all generations of a slot.
    for (int i = 0; i < 10000; i++) {
        assert_int_not_equal(c, a);
        ng_pool_release(&p, c);
        assert_false(ng_pool_has(&p, c));
        c = ng_pool_acquire(&p);
    }
    assert_false(ng_pool_has(&p, a));
    ng_pool_finish(&p);
}

// Plain memory, as jobs write it: atomics would order the workers among each other, and hide from
// ThreadSanitizer what the pool forgets to order.
struct sum {
    uint32_t hits[5000];
    bool workers_seen[8];
};

static void count_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    struct sum *s = user;
    s->workers_seen[worker] = true;
    for (uint32_t i = begin; i < end; i++)
        s->hits[i]++;
}

static void jobs_run_each_item_once(void **state)
{
    NG_UNUSED(state);
    static struct sum s;
    for (uint32_t threads = 1; threads <= 4; threads++) {
        struct ng_jobs *jobs = NULL;
        assert_int_equal(ng_jobs_create(&(struct ng_jobs_params){.threads = threads}, &jobs), NG_OK);
        for (uint32_t grain = 1; grain < 6000; grain = grain * 3 + 1) {
            memset(&s, 0, sizeof s);
            ng_jobs_for(jobs, 5000, grain, count_hits, &s);
            for (int i = 0; i < 5000; i++)
                assert_int_equal(s.hits[i], 1);
            for (uint32_t i = threads; i < NG_COUNT(s.workers_seen); i++)
                assert_false(s.workers_seen[i]);
        }
        ng_jobs_destroy(&jobs);
        assert_null(jobs);
    }
}

// Writes a file of a made-up system below the scratch directory.
static void put_file(const char *root, const char *path, const char *text)
{
    char full[1024];
    snprintf(full, sizeof full, "%s%s", root, path);
    for (char *slash = full + strlen(root) + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = 0;
        assert_int_equal(ng_file_make_directory(full), NG_OK);
        *slash = '/';
    }
    assert_int_equal(ng_file_write(full, text, strlen(text)), NG_OK);
}

static void memory_is_what_every_limit_leaves(void **state)
{
    (void)state;
    char root[512];
    test_path(root, sizeof root, "system");
    assert_int_equal(ng_file_make_directory(root), NG_OK);
    assert_true(ng_system_available_memory() > 0);
    // Nothing is left of an earlier run.
    put_file(root, "/proc/self/cgroup", "");
    put_file(root, "/sys/fs/cgroup/service/memory.stat", "");
    put_file(root, "/sys/fs/cgroup/service/memory.high", "max\n");
    put_file(root, "/sys/fs/cgroup/memory/memory.limit_in_bytes", "");
    put_file(root, "/proc/meminfo", "MemTotal: 9000 kB\nMemAvailable: 8000 kB\n");
    assert_true(ng_system_available_memory_below(root) == 8000 * 1024);
    // Version 2: its own group has no limit, the one around it has two.
    put_file(root, "/proc/self/cgroup", "0::/service/worker\n");
    put_file(root, "/sys/fs/cgroup/service/worker/memory.max", "max\n");
    put_file(root, "/sys/fs/cgroup/service/worker/memory.current", "1000\n");
    put_file(root, "/sys/fs/cgroup/service/memory.max", "700000\n");
    put_file(root, "/sys/fs/cgroup/service/memory.current", "300000\n");
    assert_true(ng_system_available_memory_below(root) == 400000);
    put_file(root, "/sys/fs/cgroup/service/memory.stat", "anon 1\ninactive_file 50000\n");
    assert_true(ng_system_available_memory_below(root) == 450000);
    put_file(root, "/sys/fs/cgroup/service/memory.high", "260000\n");
    assert_true(ng_system_available_memory_below(root) == 10000);
    put_file(root, "/sys/fs/cgroup/service/memory.high", "200000\n");
    assert_true(ng_system_available_memory_below(root) == 0);
    // Version 1, in a container that sees its own group as the root.
    put_file(root, "/proc/self/cgroup", "5:cpu:/x\n4:memory:/docker/12ab\n0::/\n");
    assert_true(ng_system_available_memory_below(root) == 8000 * 1024);
    put_file(root, "/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    put_file(root, "/sys/fs/cgroup/memory/memory.usage_in_bytes", "600000\n");
    assert_true(ng_system_available_memory_below(root) == 8000 * 1024);
    put_file(root, "/sys/fs/cgroup/memory/memory.limit_in_bytes", "900000\n");
    assert_true(ng_system_available_memory_below(root) == 300000);
}

static void rng_is_fixed_and_uniform(void **state)
{
    NG_UNUSED(state);
    struct ng_rng r = ng_rng_make(1, 2), same = ng_rng_make(1, 2), other = ng_rng_make(1, 3);
    double mean = 0;
    int differ = 0;
    for (int i = 0; i < 100000; i++) {
        float x = ng_rng_float(&r);
        assert_true(x >= 0.0f && x < 1.0f);
        assert_true(x == ng_rng_float(&same));
        differ += x != ng_rng_float(&other);
        mean += x / 1e5;
    }
    assert_true(mean > 0.495 && mean < 0.505);
    assert_true(differ > 99000);
    for (int i = 0; i < 1000; i++)
        assert_true(ng_rng_below(&r, 7) < 7);
}

// Every half against the definition of the format: (-1)^s 2^(e - 15) 1.m, or 2^-14 0.m where e is 0.
static void halfs_are_exact(void **state)
{
    NG_UNUSED(state);
    for (uint32_t h = 0; h < 65536; h++) {
        uint32_t exponent = h >> 10 & 31, mantissa = h & 1023;
        float f = ng_half_to_float((uint16_t)h);
        assert_int_equal(signbit(f) != 0, h >> 15);
        if (exponent == 31 && mantissa) {
            assert_true(isnan(f) && isnan(ng_half_to_float(ng_half_from_float(f))));
            continue;
        }
        double whole = exponent == 31 ? (double)INFINITY
                       : exponent     ? ldexp(1024 + mantissa, (int)exponent - 25)
                                      : ldexp(mantissa, -24);
        assert_true((double)fabsf(f) == whole);
        assert_int_equal(ng_half_from_float(f), h);
    }
}

// What lies between two halfs goes to the nearer one, a tie to the even one.
static void halfs_round_to_the_nearest(void **state)
{
    NG_UNUSED(state);
    for (uint32_t h = 0; h < 0x7bff; h++) {
        float a = ng_half_to_float((uint16_t)h), b = ng_half_to_float((uint16_t)(h + 1)),
              middle = (a + b) / 2;
        for (uint32_t sign = 0; sign < 2; sign++) {
            float s = sign ? -1.0f : 1.0f;
            assert_int_equal(ng_half_from_float(s * nextafterf(middle, a)), h | sign << 15);
            assert_int_equal(ng_half_from_float(s * nextafterf(middle, b)), (h + 1) | sign << 15);
            assert_int_equal(ng_half_from_float(s * middle), (h + (h & 1)) | sign << 15);
        }
    }
    assert_int_equal(ng_half_from_float(nextafterf(65520, 0)), 0x7bff);
    assert_int_equal(ng_half_from_float(65520), 0x7c00);
    assert_int_equal(ng_half_from_float(-FLT_MAX), 0xfc00);
    assert_int_equal(ng_half_from_float(FLT_TRUE_MIN), 0);
}

static void names_are_made_printable(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *name, *shown;
    } names[] = {
        {"plain", "plain"},
        {"", ""},
        {"Grün \xe7\x8e\x8b \xf0\x9f\x99\x82",
         "Grün \xe7\x8e\x8b \xf0\x9f\x99\x82"}, // two, three and four bytes
        {"a\x1b[31m\x07\n\t\x7f", "a?[31m????"},
        {"C1: \xc2\x9b"
         "31m \xc2\x80 \xc2\xa0",
         "C1: ?31m ? \xc2\xa0"}, // U+00A0 is a space
        {"\xe2\x80\xae"
         "abc\xe2\x81\xa6\xe2\x80\xa8\xd8\x9c",
         "?abc???"},
        {"\x9b\xff\xc0\xaf\xe0\x80\xaf", "???"
                                         "????"}, // bare and overlong
        {"\xed\xa0\x80\xf4\x90\x80\x80\xf8", "???????"
                                             "?"}, // a surrogate, beyond the last
        {"cut \xe7\x8e", "cut ??"},
        {"\xc3(", "?("},
    };
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        char text[64];
        snprintf(text, sizeof text, "%s", names[i].name);
        ng_make_printable(text);
        assert_string_equal(text, names[i].shown);
        struct test_log log;
        test_log_begin(&log);
        ng_log_warn("%s", names[i].name);
        test_log_end(&log);
        assert_memory_equal(log.text, names[i].shown, strlen(names[i].shown));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arena_reuses_its_blocks),    cmocka_unit_test(out_of_memory_is_one_line),
        cmocka_unit_test(pool_finds_stale_handles),   cmocka_unit_test(jobs_run_each_item_once),
        cmocka_unit_test(rng_is_fixed_and_uniform),   cmocka_unit_test(halfs_are_exact),
        cmocka_unit_test(halfs_round_to_the_nearest), cmocka_unit_test(memory_is_what_every_limit_leaves),
        cmocka_unit_test(names_are_made_printable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
