// fuzz_scenes [ROUNDS [SEED [FIRST [EVERY PROGRAM]]]]: damaged copies of valid scenes of every format, and of
// the files that they name. Each gives a picture or one clear line, in at most 20 seconds of CPU time and
// with at most 256 MiB and 20 times the file.
//
// A child opens scene after scene as `lightformer render --method reference` does and draws a picture of 8 by
// 8 pixels; when one does what it should not, the next child goes on behind it. Every EVERY-th round,
// `PROGRAM render` draws 16 by 16 pixels on the device too, whose own memory is measured once and does not
// count. What is judged wrongly is repeated by the arguments that are printed, and left in the scratch
// directory.
#define _GNU_SOURCE // wait4, MAP_ANONYMOUS, strsignal
#include "fuzz.h"
#include "made_files.h"
#include "split.h"

#include "app/stage.h"
#include "base/file.h"
#include "lightformer/reference/check.h"
#include "lightformer/reference/reference.h"
#include "lightformer/trace/tracer.h"
#include "render/snapshot.h"

#include <fcntl.h>
#include <malloc.h>
#include <math.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#define MOST_SECONDS 20
#define MOST_MEMORY  ((uint64_t)256 << 20)
#define MOST_GROWTH  20
#define MOST_FOUND   20
#define BATCH        1000

// ---- seeds -----------------------------------------------------------------------------------------------

typedef void (*damage_fn)(struct bytes *b, struct ng_rng *r);

#define TEXT(name_)                                                                                          \
    {                                                                                                        \
        .scene = name_, .from = "tests/files/" name_, .damage = mutate_text                                  \
    }
#define UNIT(name_)                                                                                          \
    {                                                                                                        \
        .scene = name_, .from = "content/unit/" name_, .damage = mutate_glb                                  \
    }
#define FILES(name_)                                                                                         \
    {                                                                                                        \
        .scene = name_, .from = "tests/files/" name_, .damage = mutate_glb                                   \
    }
#define BESIDE(scene_, file_, from_)                                                                         \
    {                                                                                                        \
        .scene = scene_, .file = file_, .from = from_, .damage = mutate_bytes                                \
    }

static void make_things(const char *path);
static void make_draco(const char *path);
static void make_webp(const char *path);

// Fifty. `file` is damaged and lies beside `scene`; null: it is the scene.
static const struct seed {
    const char *scene, *file, *from;
    void (*make)(const char *path); // instead of `from`
    damage_fn damage;
} seeds[] = {
    TEXT("good/everything.gltf"),
    TEXT("good/skin.gltf"),
    TEXT("good/cage.gltf"),
    TEXT("good/stage.gltf"),
    TEXT("good/triangle.gltf"),
    TEXT("good/materials.gltf"),
    TEXT("good/clips_three.gltf"),
    TEXT("good/no_light.gltf"),
    TEXT("good/emissive_only.gltf"),
    TEXT("geometry/figure.gltf"),
    TEXT("geometry/gpu_instancing.gltf"),
    TEXT("geometry/draco.gltf"),
    TEXT("geometry/joints_set_1.gltf"),
    TEXT("geometry/morph_weight_1.gltf"),
    TEXT("geometry/orthographic.gltf"),
    TEXT("geometry/uv_set_1.gltf"),
    TEXT("geometry/vertex_color.gltf"),
    TEXT("materials/blend_30.gltf"),
    TEXT("materials/specular_glossiness.gltf"),
    TEXT("materials/texture_transform.gltf"),
    TEXT("materials/unlit.gltf"),
    TEXT("materials/webp.gltf"),
    FILES("geometry/meshopt.glb"),
    {.scene = "geometry/draco.glb", .make = make_draco, .damage = mutate_glb},
    UNIT("accessors.glb"),
    UNIT("alpha_mask.glb"),
    UNIT("animated_fields.glb"),
    UNIT("double_sided.glb"),
    UNIT("hierarchy.glb"),
    UNIT("interpolation.glb"),
    UNIT("light_directional.glb"),
    UNIT("light_disk.glb"),
    UNIT("light_mesh.glb"),
    UNIT("light_point.glb"),
    UNIT("light_rectangle_textured.glb"),
    UNIT("normal_map.glb"),
    UNIT("subdivision.glb"),
    UNIT("textures.glb"),
    BESIDE("light_environment.glb", "environment.hdr", "content/unit/environment.hdr"),
    {.scene = "faults/sky_inf.same.gltf",
     .file = "faults/sky_inf.same.exr",
     .make = made_exr,
     .damage = mutate_bytes},
    TEXT("saving/foreign.gltf"),
    BESIDE("saving/foreign.gltf", "saving/data.bin", "tests/files/saving/data.bin"),
    BESIDE("saving/foreign.gltf", "saving/picture.png", "tests/files/saving/picture.png"),
    BESIDE("saving/foreign.gltf", "saving/picture.png", "tests/files/good/interlaced.png"),
    BESIDE("saving/foreign.gltf", "saving/picture.png", "tests/files/good/grey.jpg"),
    BESIDE("saving/foreign.gltf", "saving/picture.png", "content/unit/environment.hdr"),
    {.scene = "saving/foreign.gltf", .file = "saving/picture.png", .make = make_webp, .damage = mutate_bytes},
    {.scene = "good/objects.obj", .from = "tests/files/good/objects.obj", .damage = mutate_bytes},
    BESIDE("good/objects.obj", "good/objects.mtl", "tests/files/good/objects.mtl"),
    {.scene = "things.sh3f#1", .file = "things.sh3f", .make = make_things, .damage = mutate_bytes},
};

_Static_assert(NG_COUNT(seeds) == 50, "as many as the figures in README.md are of");

static const char *file_of(const struct seed *s)
{
    return s->file ? s->file : s->scene;
}

// What scenes name and no seed damages.
static const char *const beside[] = {"saving/foreign.gltf",    "saving/data.bin",  "saving/picture.png",
                                     "good/objects.obj",       "good/objects.mtl", "faults/sky_inf.same.gltf",
                                     "faults/sky_inf.same.exr"};

static struct bytes originals[NG_COUNT(seeds)];

static void make_things(const char *path)
{
    made_properties(path);
    struct bytes b = bytes_read(path);
    made_catalogue(path, b.data.items, b.data.count);
    ng_array_finish(&b.data);
}

static void make_draco(const char *path)
{
    struct split split;
    split_read("tests/files/geometry/draco.gltf", &split);
    split_write_glb(&split, path);
    split_finish(&split);
}

static void make_webp(const char *path)
{
    struct split split;
    split_read("tests/files/materials/webp.gltf", &split);
    assert_true(split.pictures.count > 0);
    const struct bytes *b = &split.pictures.items[0];
    assert_int_equal(ng_file_write(path, b->data.items, b->data.count), NG_OK);
    split_finish(&split);
}

static void path_of(char out[512], const char *name)
{
    test_path(out, 512, name);
}

static void write_plainly(const char *name, const struct bytes *b)
{
    char path[512];
    path_of(path, name);
    FILE *file = fopen(path, "wb"); // ng_file_write waits for the disk
    assert_non_null(file);
    assert_int_equal(fwrite(b->data.items, 1, b->data.count, file), b->data.count);
    assert_int_equal(fclose(file), 0);
}

static void copy_beside(const char *name)
{
    char from[512];
    snprintf(from, sizeof from, "tests/files/%s", name);
    struct bytes b = bytes_read(from);
    write_plainly(name, &b);
    ng_array_finish(&b.data);
}

static void make_folder(const char *name)
{
    char path[512];
    path_of(path, name);
    assert_int_equal(ng_file_make_directory(path), NG_OK);
}

static void make_seeds(void)
{
    static const char *const folders[] = {"good", "geometry", "materials", "faults", "saving"};
    for (size_t i = 0; i < NG_COUNT(folders); i++)
        make_folder(folders[i]);
    for (size_t i = 0; i < NG_COUNT(seeds); i++) {
        char path[512];
        path_of(path, file_of(&seeds[i]));
        if (seeds[i].make)
            seeds[i].make(path);
        originals[i] = bytes_read(seeds[i].make ? path : seeds[i].from);
    }
    struct bytes sky = bytes_read("content/unit/light_environment.glb");
    write_plainly("light_environment.glb", &sky);
    ng_array_finish(&sky.data);
    for (size_t i = 0; i < NG_COUNT(beside); i++)
        copy_beside(beside[i]);
}

// ---- one round -------------------------------------------------------------------------------------------

// What the child tells, in memory that both have.
static struct told {
    uint32_t round; // that is being tried
    uint32_t pictures, refusals, drawn, drawn_pictures;
    struct worst {
        double value;
        uint32_t round;
    } seconds, memory, drawn_seconds, drawn_memory; // memory: bytes above what is allowed without a file
    char why[1024];                                 // "" or what is wrong with the round
} * told;

static void note_worst(struct worst *w, double value)
{
    if (value > w->value)
        *w = (struct worst){value, told->round};
}

static double cpu_seconds(const struct rusage *u)
{
    return (double)(u->ru_utime.tv_sec + u->ru_stime.tv_sec) +
           1e-6 * (double)(u->ru_utime.tv_usec + u->ru_stime.tv_usec);
}

static double peak_bytes(const struct rusage *u)
{
    return 1024 * (double)u->ru_maxrss;
}

static ng_result trace(struct ng_stage *stage, const char *path, struct lf_tracer *tracer,
                       struct lf_reference *reference)
{
    struct lf_layer layer;
    NG_TRY(ng_stage_seek(stage, 0, NULL));
    NG_TRY(lf_check_scene(stage->world, stage->snapshot, path, LF_CHECK_WARN));
    NG_TRY(lf_tracer_update(tracer, stage->snapshot));
    NG_TRY(lf_reference_begin(reference, tracer));
    NG_TRY(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = 1}));
    NG_TRY(lf_reference_layer(reference, "beauty", &layer));
    const float *pixels = layer.pixels;
    for (uint32_t i = 0; i < layer.width * layer.height * layer.channels; i++)
        if (!isfinite(pixels[i]))
            snprintf(told->why, sizeof told->why, "a pixel that is not finite");
    free(layer.pixels);
    return NG_OK;
}

static ng_result draw(const char *path)
{
    struct ng_stage *stage = NULL;
    struct lf_tracer *tracer = NULL;
    struct lf_reference *reference = NULL;
    struct lf_reference_params params = {.width = 8, .height = 8, .depth = 3};
    ng_result r =
        ng_stage_create(&(struct ng_stage_params){.scene = path, .threads = 1, .no_device = true}, &stage);
    if (r == NG_OK)
        r = lf_tracer_create(&tracer);
    if (r == NG_OK)
        r = lf_reference_create(&params, &reference);
    if (r == NG_OK)
        r = trace(stage, path, tracer, reference);
    lf_reference_destroy(&reference);
    lf_tracer_destroy(&tracer);
    ng_stage_destroy(&stage);
    return r;
}

// One line that names the file, and an error; or neither.
static void judge(ng_result r, const struct test_log *log)
{
    bool clear = log->errors == (r != NG_OK) && r != NG_ERROR_USAGE;
    if (!clear && !told->why[0])
        snprintf(told->why, sizeof told->why, "\"%s\" with %d errors: %.800s", ng_result_text(r), log->errors,
                 log->text);
    *(r == NG_OK ? &told->pictures : &told->refusals) += 1;
}

// From here on the peak of memory is counted anew (proc(5), clear_refs).
static void forget_peak(void)
{
    malloc_trim(0);
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (file) {
        fputs("5", file);
        fclose(file);
    }
}

static void judge_cost(const struct rusage *before, const struct rusage *after, size_t file)
{
    double seconds = cpu_seconds(after) - cpu_seconds(before), grown = peak_bytes(after) - peak_bytes(before);
    double beyond = grown - MOST_GROWTH * (double)file;
    note_worst(&told->seconds, seconds);
    note_worst(&told->memory, beyond);
#if !defined __SANITIZE_ADDRESS__ // which keeps what is freed
    if (beyond > (double)MOST_MEMORY)
        snprintf(told->why, sizeof told->why, "%.0f MiB of memory for a file of %zu bytes", grown / 0x1p20,
                 file);
#endif
}

// The peak of a child that was waited for.
static int run_program(const char *program, const char *scene, struct rusage *usage)
{
    char out[512], errors[512];
    int status = 0;
    path_of(out, "picture.png");
    path_of(errors, "errors");
    pid_t child = fork();
    if (child == 0) {
        int file = open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0600);
        alarm(10 * MOST_SECONDS);
        if (file >= 0 && dup2(file, STDERR_FILENO) >= 0 && dup2(file, STDOUT_FILENO) >= 0)
            execl(program, program, "render", scene, "--method", "raster", "--size", "16x16", "-o", out,
                  (char *)NULL);
        _exit(127);
    }
    return child > 0 && wait4(child, &status, 0, usage) == child ? status : -1;
}

// Lines that begin so.
static uint32_t count_errors(void)
{
    char path[512], line[4096];
    uint32_t count = 0;
    path_of(path, "errors");
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        count += strncmp(line, "error: ", 7) == 0;
    fclose(file);
    return count;
}

static struct rusage program_base; // a picture of a triangle

static void draw_by_program(const char *program, const char *path, size_t file)
{
    struct rusage usage = {0};
    int status = run_program(program, path, &usage);
    bool whole = WIFEXITED(status) && WEXITSTATUS(status) <= 1;
    double beyond = peak_bytes(&usage) - peak_bytes(&program_base) - MOST_GROWTH * (double)file;
    told->drawn++;
    told->drawn_pictures += whole && WEXITSTATUS(status) == 0;
    note_worst(&told->drawn_seconds, cpu_seconds(&usage));
    note_worst(&told->drawn_memory, beyond);
    if (!whole || count_errors() != (uint32_t)WEXITSTATUS(status))
        snprintf(told->why, sizeof told->why, "%s render ended with %x and %u errors", program,
                 (unsigned)status, count_errors());
    else if (beyond > (double)MOST_MEMORY || cpu_seconds(&usage) > MOST_SECONDS)
        snprintf(told->why, sizeof told->why, "%s render took %.0f s and %.0f MiB", program,
                 cpu_seconds(&usage), peak_bytes(&usage) / 0x1p20);
}

// The file as this round has it; which seed it is of.
static size_t damage(uint32_t round, struct bytes *b)
{
    struct ng_rng r = ng_rng_make(fuzz.seed, round);
    size_t i = ng_rng_below(&r, NG_COUNT(seeds));
    bytes_splice(b, 0, 0, originals[i].data.items, originals[i].data.count);
    for (uint32_t n = 1 + ng_rng_below(&r, 3); n > 0; n--)
        seeds[i].damage(b, &r);
    return i;
}

static void set_limit(time_t seconds)
{
    setitimer(ITIMER_PROF, &(struct itimerval){.it_value.tv_sec = seconds}, NULL); // CPU time
    alarm(seconds ? 30 * MOST_SECONDS : 0);                                        // and for what sleeps
}

static void try_round(uint32_t round, const char *program, uint32_t every)
{
    struct bytes b = {0};
    struct rusage before, after;
    struct test_log log;
    char path[512];
    told->round = round;
    size_t i = damage(round, &b), size = b.data.count;
    write_plainly(file_of(&seeds[i]), &b);
    ng_array_finish(&b.data);
    path_of(path, seeds[i].scene);
    forget_peak();
    getrusage(RUSAGE_SELF, &before);
    set_limit(MOST_SECONDS);
    test_log_begin(&log);
    ng_result r = draw(path);
    test_log_end(&log);
    set_limit(0);
    getrusage(RUSAGE_SELF, &after);
    judge(r, &log);
    judge_cost(&before, &after, size);
    if (program && round % every == 0 && !told->why[0])
        draw_by_program(program, path, size);
    if (!told->why[0])
        write_plainly(file_of(&seeds[i]), &originals[i]);
}

// ---- all of them -----------------------------------------------------------------------------------------

static int try_rounds(uint32_t first, uint32_t end, const char *program, uint32_t every)
{
    for (uint32_t round = first; round < end && !told->why[0]; round++)
        try_round(round, program, every);
    return 0;
}

// Whether each seed draws a picture as it is; in a child, as what follows.
static bool draw_seeds(void)
{
    int status = 0;
    char path[512];
    pid_t child = fork();
    for (size_t i = 0; child == 0 && i < NG_COUNT(seeds); i++) {
        path_of(path, seeds[i].scene);
        write_plainly(file_of(&seeds[i]), &originals[i]);
        if (draw(path) != NG_OK)
            _exit(EXIT_FAILURE);
    }
    if (child == 0)
        _exit(EXIT_SUCCESS);
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

// Returns the round behind the last that was tried.
static uint32_t run_batch(uint32_t first, uint32_t end, const char *program, uint32_t every)
{
    int status = 0;
    told->why[0] = 0;
    fflush(stdout);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(try_rounds(first, end, program, every));
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFSIGNALED(status))
        snprintf(told->why, sizeof told->why, "%s", strsignal(WTERMSIG(status)));
    else if (WEXITSTATUS(status) != 0 && !told->why[0])
        snprintf(told->why, sizeof told->why, "ended with %d", WEXITSTATUS(status));
    return told->why[0] ? told->round + 1 : end;
}

// So that the next round finds whole files.
static void say_found(uint32_t round)
{
    struct bytes b = {0};
    char name[64];
    size_t i = damage(round, &b);
    snprintf(name, sizeof name, "found-%u-%.32s", round, ng_path_name(file_of(&seeds[i])));
    write_plainly(name, &b);
    write_plainly(file_of(&seeds[i]), &originals[i]);
    ng_array_finish(&b.data);
    printf("fuzz_scenes 1 %u %u (%s of %s): %s\n", fuzz.seed, round, name, seeds[i].scene, told->why);
}

static void say_worst(const char *what, const struct worst *w, double unit, const char *name)
{
    printf("%s: %.1f %s (round %u)\n", what, w->value / unit, name, w->round);
}

static void say_figures(uint32_t found)
{
    printf("%u rounds: %u pictures, %u refused with one line, %u judged wrongly\n", fuzz.rounds,
           told->pictures, told->refusals, found);
    say_worst("most CPU time", &told->seconds, 1, "s");
    say_worst("most memory beyond 20 times the file", &told->memory, 0x1p20, "MiB");
    if (!told->drawn)
        return;
    printf("%u drawn by the program: %u pictures; its own memory: %.0f MiB\n", told->drawn,
           told->drawn_pictures, peak_bytes(&program_base) / 0x1p20);
    say_worst("most CPU time", &told->drawn_seconds, 1, "s");
    say_worst("most memory beyond its own and 20 times the file", &told->drawn_memory, 0x1p20, "MiB");
}

int main(int argc, char **argv)
{
    const char *program = argc > 5 ? argv[5] : NULL;
    uint32_t every = argc > 5 ? (uint32_t)strtoul(argv[4], NULL, 10) : 1, found = 0;
    fuzz_arguments(argc, argv);
    told = mmap(NULL, sizeof *told, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (told == MAP_FAILED || every == 0)
        return EXIT_FAILURE;
    make_seeds();
    if (!draw_seeds())
        return EXIT_FAILURE;
    if (program && run_program(program, "tests/files/good/triangle.gltf", &program_base) != 0) {
        fprintf(stderr, "fuzz_scenes: %s draws no picture of a whole file\n", program);
        return EXIT_FAILURE;
    }
    uint32_t end = fuzz.first + fuzz.rounds;
    for (uint32_t at = fuzz.first; at < end && found < MOST_FOUND;) {
        at = run_batch(at, at + BATCH < end ? at + BATCH : end, program, every);
        found += told->why[0] != 0;
        if (told->why[0])
            say_found(told->round);
    }
    say_figures(found);
    return found ? EXIT_FAILURE : EXIT_SUCCESS;
}
