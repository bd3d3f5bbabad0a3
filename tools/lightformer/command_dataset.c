// lightformer dataset: samples of a scene in shards; a look at what is there.
#include "commands.h"
#include "files.h"
#include "opening.h"
#include "output.h"
#include "progress.h"
#include "scene_file.h"

#include "app/stage.h"
#include "base/file.h"
#include "lightformer/dataset/dataset.h"
#include "lightformer/dataset/manifest.h"

#include <string.h>

struct dataset {
    const char *scene, *output, *check, *sheet, *camera, *device, *targets;
    uint32_t count, seed, size, crop, crops, spp, depth, shard, vpls, threads;
    double time;
    struct opening opening;
};

#define NUMBER(name_, member_, fallback_, min_, max_, doc_)                                                  \
    {                                                                                                        \
        .name = (name_), .kind = CLI_COUNT, .offset = offsetof(struct dataset, member_), .value = "N",       \
        .fallback = (fallback_), .min = (min_), .max = (max_), .doc = (doc_)                                 \
    }

// A look at a data set makes none.
static const char *const not_with_check[] = {"SCENE",    "--output",    "--count", "--seed",    "--size",
                                             "--crop",   "--crops",     "--spp",   "--targets", "--depth",
                                             "--shard",  "--vpls",      "--time",  "--camera",  "--threads",
                                             "--device", OPENING_NAMES, NULL};

static const struct cli_option options[] = {
    {.name = "SCENE",
     .kind = CLI_TEXT,
     .flags = CLI_READS,
     .offset = offsetof(struct dataset, scene),
     .doc = "a glTF file (.glb or .gltf) with variation components"},
    {.name = "--output",
     .letter = 'o',
     .kind = CLI_TEXT,
     .flags = CLI_WRITES,
     .offset = offsetof(struct dataset, output),
     .value = "DIR",
     .doc = "the folder; what it has already is kept"},
    NUMBER("--count", count, "100", 1, UINT32_MAX, "samples"),
    NUMBER("--seed", seed, "0", 0, UINT32_MAX, "of the first sample; the next one has the next seed"),
    NUMBER("--size", size, "512", 1, LF_DATASET_MAX_SIZE,
           "pixels a side of the frame that crops are taken from"),
    NUMBER("--crop", crop, "128", 0, LF_DATASET_MAX_SIZE, "pixels a side of a crop; 0: whole frames"),
    NUMBER("--crops", crops, "4", 1, UINT32_MAX, "crops of a frame"),
    NUMBER("--spp", spp, "64", 1, UINT32_MAX, "paths a pixel of the targets"),
    {.name = "--targets",
     .kind = CLI_TEXT,
     .flags = CLI_READS,
     .offset = offsetof(struct dataset, targets),
     .value = "DIR",
     .doc =
         "take targets from this data set of the same settings, where it has them: after a change of inputs"},
    NUMBER("--depth", depth, "0", 0, UINT32_MAX,
           "segments of these paths, the camera's included: 2 gives direct light; 0: no limit"),
    NUMBER("--shard", shard, "64", 1, UINT32_MAX, "crops a file"),
    NUMBER("--vpls", vpls, "500", 0, UINT32_MAX, "direct VPLs of a light"),
    {.name = "--time",
     .kind = CLI_REAL,
     .offset = offsetof(struct dataset, time),
     .value = "S",
     .fallback = "0",
     .max = 1e6,
     .doc = "seconds into the animation, where time does not vary"},
    {.name = "--camera",
     .kind = CLI_TEXT,
     .offset = offsetof(struct dataset, camera),
     .value = "NAME",
     .doc = "a camera of the scene; the first one if not given"},
    {.name = "--check",
     .kind = CLI_TEXT,
     .flags = CLI_READS,
     .offset = offsetof(struct dataset, check),
     .value = "DIR",
     .excludes = not_with_check,
     .doc = "instead: read every shard of a data set and find damage"},
    {.name = "--contact-sheet",
     .kind = CLI_TEXT,
     .flags = CLI_WRITES,
     .offset = offsetof(struct dataset, sheet),
     .value = "OUT.png",
     .doc = "the first crops with all channels side by side"},
    CLI_THREADS(struct dataset),
    CLI_DEVICE(struct dataset),
    CLI_OPENING(struct dataset),
};

static bool check_options(const struct dataset *d)
{
    const char *wrong = NULL;
    if (!d->check && !(d->scene && d->output))
        wrong = "SCENE and --output are needed (or --check)";
    else if (d->sheet && strcmp(ng_path_extension(d->sheet), "png") != 0)
        wrong = "--contact-sheet writes a .png";
    else if (d->crop > d->size)
        wrong = "crops are larger than the frame (--crop, --size)";
    else if (d->count - 1 > UINT32_MAX - d->seed)
        wrong = "seeds go up to 4294967295, the last sample's too (--seed, --count)";
    if (wrong)
        fprintf(stderr, "lightformer dataset: %s\n", wrong);
    return !wrong;
}

static bool show_progress(void *user, uint32_t done, uint32_t count)
{
    (void)count;
    progress_update(user, done);
    return true;
}

static void print_report(const struct lf_dataset_report *r)
{
    printf("%u samples, %u crops in %.1f s", r->samples, r->crops, r->seconds);
    if (r->crops)
        printf(": %.1f crops a minute", 60 * r->crops / r->seconds);
    puts("");
    if (r->kept || r->redone)
        printf("%u of %u shards were there already, %u were damaged and made again\n", r->kept, r->shards,
               r->redone);
    for (int i = 0; r->crops && i < LF_STAGES; i++)
        printf("  %-8s %5.1f %%  %7.3f s a crop\n", lf_stage_names[i], 100 * r->spent[i] / r->seconds,
               r->spent[i] / r->crops);
}

static ng_result make(const struct dataset *d, struct ng_stage *stage)
{
    struct progress progress;
    struct lf_dataset_report report;
    struct lf_dataset_params params = {.world = stage->world,
                                       .assets = stage->assets,
                                       .gpu = stage->gpu,
                                       .jobs = stage->jobs,
                                       .directory = d->output,
                                       .program = NG_VERSION,
                                       .scene = ng_path_name(d->scene),
                                       .scene_hash = opening_hash(&d->opening, stage->scene.hash),
                                       .camera = d->camera,
                                       .time = d->time,
                                       .seed = d->seed,
                                       .count = d->count,
                                       .size = d->size,
                                       .crop = d->crop,
                                       .crops = d->crops,
                                       .spp = d->spp,
                                       .depth = d->depth,
                                       .shard = d->shard,
                                       .vpls = d->vpls,
                                       .targets = d->targets,
                                       .progress = show_progress,
                                       .user = &progress};
    progress_begin(&progress, "sample", d->count);
    ng_result result = lf_dataset_make(&params, &report);
    progress_end(&progress);
    if (result == NG_OK)
        print_report(&report);
    return result;
}

static void add_scene_file(void *user, const char *path)
{
    cli_files_read(user, "a file of SCENE", path);
}

// An exit code.
static int make_dataset(const struct dataset *d, struct cli_files *files)
{
    struct ng_stage_params params = {
        .scene = d->scene, .device = d->device, .threads = d->threads, .file = add_scene_file, .user = files};
    struct ng_stage *stage;
    opening_apply(&d->opening, &params);
    if (scene_file_check(d->scene) != NG_OK || ng_stage_create(&params, &stage) != NG_OK)
        return CLI_FAILED;
    int code = CLI_USAGE;
    if (cli_files_check(files, "dataset"))
        code = make(d, stage) == NG_OK ? CLI_DONE : CLI_FAILED;
    ng_stage_destroy(&stage);
    return code;
}

// An exit code.
static int check(const struct dataset *d)
{
    struct lf_dataset_contents c;
    ng_result result = lf_dataset_check(d->check, &c);
    if (c.shards)
        printf("%u shards, %llu samples, %llu tensors, %.1f MiB; %u shards damaged\n", c.shards,
               (unsigned long long)c.samples, (unsigned long long)c.tensors, (double)c.bytes / (1 << 20),
               c.damaged);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

// A data set whose files are among those of the command.
struct folder {
    struct cli_files *files;
    const char *role, *path;
    bool written;
};

static void add_file_of(void *user, const char *name)
{
    const struct folder *f = user;
    struct lf_shard shard;
    char path[4096];
    if (strcmp(name, "manifest.json") != 0 && !lf_shard_of_name(name, &shard))
        return;
    int n = snprintf(path, sizeof path, "%s/%s", f->path, name);
    if (n > 0 && (size_t)n < sizeof path)
        (f->written ? cli_files_write : cli_files_read)(f->files, f->role, path);
}

// Those that are there: links and other names of files lead from elsewhere only to these.
static ng_result add_folder(struct cli_files *files, const char *role, const char *path, bool written)
{
    struct folder folder = {files, role, path, written};
    return path && ng_file_exists(path) ? ng_file_list(path, add_file_of, &folder) : NG_OK;
}

static ng_result find_files(const struct dataset *d, struct cli_files *files)
{
    cli_files_add_options(files, &cli_dataset_command, d);
    NG_TRY(add_folder(files, "--output", d->output, true));
    NG_TRY(add_folder(files, "--targets", d->targets, false));
    return add_folder(files, "--check", d->check, false);
}

static int run_on(const struct dataset *d, struct cli_files *files)
{
    if (find_files(d, files) != NG_OK)
        return CLI_FAILED;
    if (!cli_files_check(files, "dataset"))
        return CLI_USAGE;
    if (d->sheet && ng_file_check_writable(d->sheet) != NG_OK)
        return CLI_FAILED;
    int code = d->check ? check(d) : make_dataset(d, files);
    if (code == CLI_DONE && d->sheet &&
        lf_dataset_contact_sheet(d->check ? d->check : d->output, d->sheet, 0) != NG_OK)
        code = CLI_FAILED;
    return code;
}

static int run(const void *args)
{
    const struct dataset *d = args;
    struct cli_files files = {0};
    if (!check_options(d) || !opening_check(&d->opening, "dataset"))
        return CLI_USAGE;
    int code = run_on(d, &files);
    cli_files_finish(&files);
    return code;
}

const struct cli_command cli_dataset_command = {
    .name = "dataset",
    .summary = "Makes training data of a scene: inputs and path-traced targets by seed.",
    .notes = "Run it again after an interruption: whole shards are kept, damaged ones made anew.\n"
             "Several machines: give each a range of seeds (--seed, --count) that begins and ends at a "
             "multiple of the samples\nof a shard, copy the shards into one folder, and run the whole range "
             "there.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct dataset),
    .run = run,
};
