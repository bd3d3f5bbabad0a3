// lightformer render: a scene to pictures, without a display.
#include "commands.h"
#include "output.h"
#include "progress.h"

#include "app/stage.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

#define MAX_LAYERS 20

struct render {
    const char *scene, *camera, *graph, *device;
    struct cli_texts outputs;
    uint32_t method, aovs, threads;
    struct cli_size size;
    struct cli_range frames;
    double time;
};

const char *const cli_methods[] = {"raster", NULL};

// What --aov takes: the names of layers, then "all".
static const char *aov_name(uint32_t index)
{
    const struct ng_layer_info *info = ng_renderer_layer_info(index);
    if (info)
        return info->name;
    return index > 0 && ng_renderer_layer_info(index - 1) ? "all" : NULL;
}

static const struct cli_option options[] = {
    CLI_SCENE(struct render),
    {.name = "--output",
     .letter = 'o',
     .kind = CLI_TEXTS,
     .flags = CLI_REQUIRED,
     .offset = offsetof(struct render, outputs),
     .value = "OUT",
     .doc = "where to write, .exr or .png; may be given more than once"},
    CLI_METHOD(struct render),
    CLI_PIXELS(struct render, "512x512"),
    {.name = "--time",
     .kind = CLI_REAL,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, time),
     .value = "S",
     .fallback = "0",
     .min = 0,
     .max = 1e6,
     .doc = "seconds into the animation"},
    {.name = "--frames",
     .kind = CLI_RANGE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, frames),
     .value = "A..B",
     .max = 1e6,
     .doc = "a sequence instead, A and B included, at 30 frames a second"},
    {.name = "--camera",
     .kind = CLI_TEXT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, camera),
     .value = "NAME",
     .doc = "a camera of the scene; the first one if not given"},
    {.name = "--aov",
     .kind = CLI_SET,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, aovs),
     .value = "LIST",
     .choice = aov_name,
     .doc = "more layers for the EXR"},
    {.name = "--graph",
     .kind = CLI_TEXT,
     .offset = offsetof(struct render, graph),
     .value = "FILE.dot",
     .doc = "write the render graph of the last frame"},
    CLI_THREADS(struct render),
    CLI_DEVICE(struct render),
};

// A rendering under way.
struct job {
    const struct render *render;
    struct ng_stage *stage;
    uint64_t scene_hash;
    const char *layers[MAX_LAYERS]; // of an EXR: beauty and what --aov names
    uint32_t layer_count;
    const char *wanted[MAX_LAYERS + 1]; // the same and "display", as far as outputs need them
    uint32_t wanted_count;
};

static bool is_exr(const char *path)
{
    return strcmp(output_base_layer(path), "beauty") == 0;
}

// What the tables cannot say; false, reported, if it does not hold.
static bool check_options(const struct render *r)
{
    if (r->frames.given && r->time != 0) {
        fputs("lightformer render: --time and --frames exclude each other\n", stderr);
        return false;
    }
    bool exr = false;
    for (uint32_t i = 0; i < r->outputs.count; i++) {
        if (!output_knows(r->outputs.items[i])) {
            fprintf(stderr, "lightformer render: --output: \"%s\" ends neither in .exr nor in .png\n",
                    r->outputs.items[i]);
            return false;
        }
        exr |= is_exr(r->outputs.items[i]);
    }
    if (r->aovs && !exr)
        fputs("lightformer render: --aov needs an output that ends in .exr\n", stderr);
    return !r->aovs || exr;
}

// Whether "all" means this layer: what the method does not compute is an error only if asked for by name.
static bool all_has(const struct render *r, const char *layer)
{
    return strcmp(cli_methods[r->method], "raster") != 0 || strcmp(layer, "indirect") != 0;
}

static bool wants_layer(const struct render *r, uint32_t index, const char *layer)
{
    uint32_t all = 0;
    while (ng_renderer_layer_info(all))
        all++;
    // "beauty" is in every EXR.
    return strcmp(layer, "beauty") == 0 || r->aovs >> index & 1 || (r->aovs >> all & 1 && all_has(r, layer));
}

static void choose_layers(struct job *job)
{
    const struct render *r = job->render;
    const struct ng_layer_info *info;
    for (uint32_t i = 0; (info = ng_renderer_layer_info(i)) && job->layer_count < MAX_LAYERS; i++) {
        if (wants_layer(r, i, info->name))
            job->layers[job->layer_count++] = info->name;
    }
    bool exr = false, png = false;
    for (uint32_t i = 0; i < r->outputs.count; i++)
        *(is_exr(r->outputs.items[i]) ? &exr : &png) = true;
    for (uint32_t i = 0; exr && i < job->layer_count; i++)
        job->wanted[job->wanted_count++] = job->layers[i];
    if (png)
        job->wanted[job->wanted_count++] = "display";
}

static ng_result hash_scene(const char *path, uint64_t *out)
{
    void *data;
    size_t size;
    NG_TRY(ng_file_read(path, 0, &data, &size));
    *out = ng_hash_bytes(0, data, size);
    free(data);
    return NG_OK;
}

static ng_result draw(const struct job *job, double time)
{
    struct ng_stage_frame frame = {
        .time = time,
        .camera = job->render->camera,
        .width = job->render->size.width,
        .height = job->render->size.height,
        .method = cli_methods[job->render->method],
        .layers = job->wanted,
        .layer_count = job->wanted_count,
    };
    return ng_stage_draw(job->stage, &frame);
}

// Writes the last frame to one file. `values` are the options that make exactly this picture.
static ng_result write_output(const struct job *job, const char *path, const struct render *values)
{
    char command[1024];
    if (!cli_canonical(&cli_render_command, values, command, sizeof command)) {
        ng_log_error("%s: the scene's or camera's name is too long for the picture's metadata", path);
        return NG_ERROR_UNSUPPORTED;
    }
    struct output_origin origin = {command, job->scene_hash};
    NG_TRY(output_write(path, job->stage->renderer, job->layers, job->layer_count, &origin));
    puts(path);
    return NG_OK;
}

static ng_result render_picture(struct job *job)
{
    const struct render *r = job->render;
    NG_TRY(draw(job, r->time));
    for (uint32_t i = 0; i < r->outputs.count; i++)
        NG_TRY(write_output(job, r->outputs.items[i], r));
    return NG_OK;
}

static ng_result write_numbered(const struct job *job, uint32_t number)
{
    const struct render *r = job->render;
    struct render values = *r; // the same picture, asked for alone
    values.frames.first = values.frames.last = number;
    for (uint32_t i = 0; i < r->outputs.count; i++) {
        char path[4096];
        if (!output_numbered(r->outputs.items[i], number, path, sizeof path)) {
            ng_log_error("%s: the path is too long", r->outputs.items[i]);
            return NG_ERROR_IO;
        }
        NG_TRY(write_output(job, path, &values));
    }
    return NG_OK;
}

static ng_result render_sequence(struct job *job)
{
    const struct cli_range *frames = &job->render->frames;
    ng_result result = NG_OK;
    struct progress progress;
    progress_begin(&progress, "frame", frames->last - frames->first + 1);
    for (uint32_t n = frames->first; n <= frames->last && result == NG_OK; n++) {
        progress_update(&progress, n - frames->first);
        result = draw(job, n / CLI_FRAMES_A_SECOND);
        if (result == NG_OK)
            result = write_numbered(job, n);
    }
    progress_end(&progress);
    return result;
}

static ng_result write_graph(struct job *job, const char *path)
{
    char *text = ng_graph_dump(ng_renderer_graph(job->stage->renderer), NG_DUMP_DOT);
    if (!text) {
        ng_log_error("%s: out of memory for the render graph", path);
        return NG_ERROR_MEMORY;
    }
    ng_result result = ng_file_write(path, text, strlen(text));
    free(text);
    return result;
}

// Motion is measured from one frame before, so that a picture does not depend on the sequence it is in.
static ng_result begin_motion(struct job *job)
{
    const struct render *r = job->render;
    double first = r->frames.given ? r->frames.first / CLI_FRAMES_A_SECOND : r->time;
    double before = first - 1 / CLI_FRAMES_A_SECOND;
    return before < 0 ? NG_OK : ng_stage_seek(job->stage, before, r->camera);
}

static ng_result render(struct job *job)
{
    const struct render *r = job->render;
    struct ng_stage_params params = {.scene = r->scene, .device = r->device, .threads = r->threads};
    NG_TRY(ng_stage_create(&params, &job->stage));
    NG_TRY(hash_scene(r->scene, &job->scene_hash));
    choose_layers(job);
    NG_TRY(begin_motion(job));
    NG_TRY(r->frames.given ? render_sequence(job) : render_picture(job));
    return r->graph ? write_graph(job, r->graph) : NG_OK;
}

static int run(const void *args)
{
    struct job job = {.render = args};
    if (!check_options(job.render))
        return CLI_USAGE;
    ng_result result = render(&job);
    ng_stage_destroy(&job.stage);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_render_command = {
    .name = "render",
    .summary = "Renders a scene to pictures; no display is needed.",
    .notes = "--aov all: every layer that the method computes.\n"
             "A sequence is numbered: -o out/chess.png --frames 0..59 writes out/chess.0000.png to "
             "out/chess.0059.png.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct render),
    .run = run,
};
