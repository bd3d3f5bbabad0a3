// lightformer render: a scene to pictures, without a display.
#include "commands.h"
#include "files.h"
#include "opening.h"
#include "output.h"
#include "pose.h"
#include "progress.h"
#include "render_antialias.h"
#include "render_clues.h"
#include "render_reference.h"
#include "scene_file.h"

#include "app/camera_controller.h"
#include "app/stage.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/printable.h"
#include "components/camera.h"
#include "components/components.h"
#include "lightformer/dataset/sampler.h"
#include "lightformer/methods/methods.h"
#include "lightformer/neural/neural.h"
#include "scene/world.h"

#include <stdlib.h>
#include <string.h>

#define DEFAULT_SAMPLES 64

struct render {
    const char *scene, *camera, *pose, *graph, *device, *resume, *weights;
    struct cli_texts outputs, clues;
    uint32_t method, gbuffer, aovs, threads;
    struct cli_size size, light;
    struct cli_range frames, variation;
    double time;
    bool antialias;
    uint32_t samples; // of --aa, and of the method "reference"
    // Of the latter:
    uint32_t depth, sampler, seed;
    double clamp, time_limit;
    struct opening opening;
};

static const char *const samplers[] = {
    [LF_SAMPLER_SOBOL] = "sobol", [LF_SAMPLER_INDEPENDENT] = "independent", NULL};

static bool is_reference(const struct render *r)
{
    return strcmp(lf_method_name(r->method), "reference") == 0;
}

// Whether a method makes a layer: the reference has its own, the others those of the renderer.
static bool makes(uint32_t method, const char *layer)
{
    const struct lf_method_info *m = lf_method_info(method);
    if (strcmp(m->name, "reference") == 0)
        return lf_reference_find_layer(layer) != NULL;
    return ng_renderer_find_layer(layer) && (m->indirect || strcmp(layer, "indirect") != 0);
}

// The layers of all methods: the renderer's, then what the reference has besides. Null past the end.
static const char *layer_name(uint32_t index)
{
    static const char *const more[] = {"variance", "samples"};
    uint32_t count = 0;
    while (ng_renderer_layer_info(count))
        count++;
    if (index < count)
        return ng_renderer_layer_info(index)->name;
    return index - count < NG_COUNT(more) ? more[index - count] : NULL;
}

// What --aov takes: the names of layers, then "all".
static const char *aov_name(uint32_t index)
{
    if (layer_name(index))
        return layer_name(index);
    return index > 0 && layer_name(index - 1) ? "all" : NULL;
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
    CLI_METHOD(struct render, method_option),
    CLI_WEIGHTS(struct render),
    CLI_GBUFFER(struct render),
    CLI_PIXELS(struct render, "512x512"),
    {.name = "--light",
     .kind = CLI_SIZE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, light),
     .value = "WxH",
     .min = 1,
     .max = 16384,
     .doc = "computes light for so many pixels and upsamples it, as view does while something moves"},
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
    {.name = "--variation",
     .kind = CLI_RANGE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, variation),
     .value = "SEED",
     .max = UINT32_MAX,
     .doc = "the sample that a data set has under this seed"},
    {.name = "--camera",
     .kind = CLI_TEXT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, camera),
     .value = "NAME",
     .doc = "a camera of the scene; the first one if not given"},
    CLI_POSE(struct render),
    {.name = "--aov",
     .kind = CLI_SET,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, aovs),
     .value = "LIST",
     .choice = aov_name,
     .doc = "more layers for the EXR"},
    {.name = "--clue",
     .kind = CLI_TEXTS,
     .offset = offsetof(struct render, clues),
     .value = "NAME=FILE.exr",
     .doc = "neural: also write an input of the network or an embedding"},
    {.name = "--graph",
     .kind = CLI_TEXT,
     .flags = CLI_WRITES,
     .offset = offsetof(struct render, graph),
     .value = "FILE.dot",
     .doc = "write the render graph of the last frame; .txt or .json: with the memory of each resource"},
    CLI_OPENING(struct render),
    CLI_THREADS(struct render),
    CLI_DEVICE(struct render),
    {.name = "--spp",
     .kind = CLI_COUNT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, samples),
     .value = "N",
     .min = 1,
     .max = 1000000,
     .doc = "reference: paths a pixel, 64 if not given; others with --aa: pictures that are averaged, 17"},
    {.name = "--depth",
     .kind = CLI_COUNT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, depth),
     .value = "N",
     .max = 1 << 16,
     .doc = "reference: longest path, 1: emission, 2: direct light; 0: no limit"},
    {.name = "--sampler",
     .kind = CLI_CHOICE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, sampler),
     .value = "NAME",
     .choices = samplers,
     .doc = "reference: random numbers; sobol if not given"},
    {.name = "--seed",
     .kind = CLI_COUNT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, seed),
     .value = "N",
     .max = UINT32_MAX,
     .doc = "reference: of the random numbers"},
    {.name = "--clamp",
     .kind = CLI_REAL,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, clamp),
     .value = "L",
     .max = 1e30,
     .doc = "reference: largest indirect radiance of one path (biased); 0: none"},
    {.name = "--aa",
     .kind = CLI_FLAG,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct render, antialias),
     .doc = "antialiased: filtered over the pixel instead of seen through its centre"},
    {.name = "--time-limit",
     .kind = CLI_REAL,
     .offset = offsetof(struct render, time_limit),
     .value = "S",
     .max = 1e9,
     .doc = "reference: stop after so many seconds; 0: none"},
    {.name = "--resume",
     .kind = CLI_TEXT,
     .flags = CLI_WRITES,
     .offset = offsetof(struct render, resume),
     .value = "FILE",
     .doc = "reference: keep the paths in this file, and go on from it if it is there"},
};

// A rendering under way.
struct job {
    const struct render *render;
    struct cli_files files; // what is read and written
    struct ng_stage *stage;
    struct lf_method *method;              // null for the reference, which takes no renderer
    struct render_reference *reference;    // null for the renderer's methods
    struct lf_scene_sampler *sampler;      // null without --variation
    const char *camera;                    // that pictures are of; null: the scene's first
    double time;                           // of a single picture
    uint32_t samples;                      // of the last picture
    const char *layers[OUTPUT_MAX_LAYERS]; // of an EXR: beauty and what --aov names
    uint32_t layer_count;
    const char *wanted[OUTPUT_MAX_LAYERS + 1]; // the same and "display", as far as outputs need them
    uint32_t wanted_count;
    bool display;
    struct render_clues clues;
    struct render_middles middles; // of the last picture, with --aa
};

static bool is_exr(const char *path)
{
    return strcmp(output_base_layer(path), "beauty") == 0;
}

static bool refuse(const char *why)
{
    fprintf(stderr, "lightformer render: %s\n", why);
    return false;
}

static bool check_method(const struct render *r)
{
    bool asked = r->depth || r->sampler || r->seed || r->clamp > 0 || r->time_limit > 0 || r->resume;
    if (r->weights && strcmp(lf_method_name(r->method), "neural") != 0)
        return refuse("--weights needs --method neural");
    if (r->gbuffer && strcmp(lf_method_name(r->method), "neural") != 0)
        return refuse("--gbuffer needs --method neural");
    if (r->clues.count && strcmp(lf_method_name(r->method), "neural") != 0)
        return refuse("--clue needs --method neural");
    if (r->clues.count && r->frames.given)
        return refuse("--clue is of one picture, not of --frames");
    if (r->clues.count && r->antialias)
        return refuse("--clue is of one picture, not of the mean of several that --aa makes");
    if (!render_clues_check(&r->clues))
        return false;
    if (r->light.width && (is_reference(r) || r->antialias || r->aovs || r->clues.count))
        return refuse(
            "--light is of one picture, and has neither layers nor clues; --method reference has none");
    if (!is_reference(r) && r->samples && !r->antialias)
        return refuse("--spp needs --aa, or --method reference");
    if (!is_reference(r))
        return !asked || refuse("--depth, --sampler, --seed, --clamp, --time-limit and --resume need "
                                "--method reference");
    if (r->graph || r->device)
        return refuse("--method reference has neither a graph nor a device");
    if (r->resume && r->frames.given)
        return refuse("--resume keeps one picture, not --frames");
    return true;
}

// Says that the method does not make a layer, and which do.
static bool refuse_layer(const struct render *r, const char *layer)
{
    const char *comma = "", *name;
    fprintf(stderr, "lightformer render: --method %s does not make the layer \"%s\", only",
            lf_method_name(r->method), layer);
    for (uint32_t i = 0; (name = lf_method_name(i)); i++) {
        if (!makes(i, layer))
            continue;
        fprintf(stderr, "%s --method %s", comma, name);
        comma = ",";
    }
    fputc('\n', stderr);
    return false;
}

// Of the layers that are asked for by name.
static bool check_layers(const struct render *r)
{
    const char *layer;
    for (uint32_t i = 0; (layer = layer_name(i)); i++)
        if (r->aovs >> i & 1 && !makes(r->method, layer))
            return refuse_layer(r, layer);
    return true;
}

// What the tables cannot say; false, reported, if it does not hold.
static bool check_options(const struct render *r)
{
    if (!check_method(r) || !opening_check(&r->opening, "render") || !pose_check(r->pose, "render"))
        return false;
    if (r->pose && r->variation.given)
        return refuse("--variation has a camera of its own, and no --pose");
    if (r->frames.given && r->time != 0) {
        fputs("lightformer render: --time and --frames exclude each other\n", stderr);
        return false;
    }
    if (r->variation.given && (r->frames.given || r->variation.first != r->variation.last))
        return refuse("--variation takes one seed, and no --frames");
    bool exr = false;
    for (uint32_t i = 0; i < r->outputs.count; i++) {
        if (!output_knows(r->outputs.items[i])) {
            ng_print_line(stderr, "lightformer render: --output: \"%s\" ends neither in .exr nor in .png",
                          r->outputs.items[i]);
            return false;
        }
        exr |= is_exr(r->outputs.items[i]);
    }
    if (r->aovs && !exr)
        return refuse("--aov needs an output that ends in .exr");
    return check_layers(r);
}

static bool wants_layer(const struct render *r, uint32_t index, const char *layer)
{
    uint32_t all = 0;
    while (layer_name(all))
        all++;
    // "beauty" is in every EXR, and "all" is what the method makes.
    return strcmp(layer, "beauty") == 0 || r->aovs >> index & 1 ||
           (r->aovs >> all & 1 && makes(r->method, layer));
}

static void choose_layers(struct job *job)
{
    const struct render *r = job->render;
    bool exr = false;
    for (uint32_t i = 0; i < r->outputs.count; i++)
        *(is_exr(r->outputs.items[i]) ? &exr : &job->display) = true;
    for (uint32_t i = 0; exr && layer_name(i) && job->layer_count < OUTPUT_MAX_LAYERS; i++) {
        if (wants_layer(r, i, layer_name(i)))
            job->layers[job->layer_count++] = layer_name(i);
    }
    for (uint32_t i = 0; i < job->layer_count; i++)
        job->wanted[job->wanted_count++] = job->layers[i];
    if (job->display)
        job->wanted[job->wanted_count++] = "display";
}

static ng_result draw(struct job *job, double time)
{
    if (job->reference) {
        NG_TRY(ng_stage_advance(job->stage, time, job->camera));
        return render_reference_draw(job->reference, job->stage->snapshot, &job->samples);
    }
    struct ng_stage_frame frame = {
        .time = time,
        .camera = job->camera,
        .width = job->render->size.width,
        .height = job->render->size.height,
        .light_width = job->render->light.width,
        .light_height = job->render->light.height,
        .method = lf_method_name(job->render->method),
        .layers = job->wanted,
        .layer_count = job->wanted_count,
        .resources = job->clues.resources,
        .resource_count = job->render->clues.count,
    };
    if (!job->render->antialias)
        return ng_stage_draw(job->stage, &frame);
    job->samples = job->render->samples ? job->render->samples : RENDER_ANTIALIAS_SAMPLES;
    return render_antialias_draw(job->stage, &frame, job->samples, &job->middles);
}

// The last frame, as the renderer has it.
static ng_result fetch_frame(const struct job *job, struct output_layer *layers, struct output_picture *out)
{
    struct ng_renderer *renderer = job->stage->renderer;
    *out = (struct output_picture){.layers = layers, .layer_count = job->layer_count};
    for (uint32_t i = 0; i < job->layer_count; i++) {
        const struct output_layer *middle = render_middles_find(&job->middles, job->layers[i]);
        if (middle)
            layers[i] = *middle;
        else
            NG_TRY(render_fetch_layer(renderer, job->layers[i], &layers[i], &out->width, &out->height));
    }
    return job->display ? ng_renderer_display(renderer, &out->display, &out->width, &out->height) : NG_OK;
}

static ng_result fetch(const struct job *job, struct output_layer *layers, struct output_picture *out)
{
    if (job->reference)
        return render_reference_fetch(job->reference, job->layers, job->layer_count, job->display, out);
    return fetch_frame(job, layers, out);
}

// Writes a picture to one file. `values` are the options that make exactly this picture.
static ng_result write_output(const struct job *job, const char *path, const struct output_picture *picture,
                              const struct render *values)
{
    char command[1024];
    struct render made = *values;
    made.samples = job->samples;
    if (!cli_canonical(&cli_render_command, &made, command, sizeof command)) {
        ng_log_error("%s: the scene's or camera's name is too long for the picture's metadata", path);
        return NG_ERROR_UNSUPPORTED;
    }
    struct output_origin origin = {command, job->stage->scene.hash};
    NG_TRY(output_write(path, picture, &origin));
    puts(path);
    return NG_OK;
}

static ng_result render_picture(struct job *job)
{
    const struct render *r = job->render;
    struct output_layer layers[OUTPUT_MAX_LAYERS];
    struct output_picture picture;
    struct progress progress; // the reference shows a bar of its own while it draws
    progress_begin(&progress, "step", 2 + r->outputs.count);
    ng_result result = draw(job, job->time);
    progress_update(&progress, 1);
    if (result == NG_OK)
        result = fetch(job, layers, &picture);
    for (uint32_t i = 0; i < r->outputs.count && result == NG_OK; i++) {
        progress_update(&progress, 2 + i);
        result = write_output(job, r->outputs.items[i], &picture, r);
    }
    progress_end(&progress);
    return result;
}

static ng_result number_path(const char *output, uint32_t number, char *out, size_t size)
{
    if (output_numbered(output, number, out, size))
        return NG_OK;
    ng_log_error("%s: the path is too long", output);
    return NG_ERROR_IO;
}

static ng_result write_numbered(const struct job *job, uint32_t number)
{
    const struct render *r = job->render;
    struct render values = *r; // the same picture, asked for alone
    values.frames.first = values.frames.last = number;
    struct output_layer layers[OUTPUT_MAX_LAYERS];
    struct output_picture picture;
    NG_TRY(fetch(job, layers, &picture));
    for (uint32_t i = 0; i < r->outputs.count; i++) {
        char path[4096];
        NG_TRY(number_path(r->outputs.items[i], number, path, sizeof path));
        NG_TRY(write_output(job, path, &picture, &values));
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

static enum ng_dump dump_of(const char *path)
{
    const char *extension = ng_path_extension(path);
    return strcmp(extension, "txt") == 0    ? NG_DUMP_TEXT
           : strcmp(extension, "json") == 0 ? NG_DUMP_JSON
                                            : NG_DUMP_DOT;
}

static ng_result write_graph(struct job *job, const char *path)
{
    char *text = ng_graph_dump(ng_renderer_graph(job->stage->renderer), dump_of(path));
    if (!text)
        return ng_out_of_memory(path);
    ng_result result = ng_file_write(path, text, strlen(text));
    free(text);
    return result;
}

// Motion is measured from one frame before, so that a picture does not depend on the sequence it is in.
static ng_result begin_motion(struct job *job)
{
    const struct render *r = job->render;
    double first = r->frames.given ? r->frames.first / CLI_FRAMES_A_SECOND : job->time;
    double before = first - 1 / CLI_FRAMES_A_SECOND;
    return before < 0 ? NG_OK : ng_stage_seek(job->stage, before, job->camera);
}

// Scene, how it was opened, place and time: what a reference follows from besides its own parameters.
static uint64_t hash_picture(const struct job *job)
{
    const struct render *r = job->render;
    uint64_t hash =
        ng_hash_bytes(opening_hash(&r->opening, job->stage->scene.hash), &job->time, sizeof job->time);
    if (r->variation.given)
        hash = ng_hash_combine(hash, r->variation.first);
    if (r->pose)
        hash = ng_hash_combine(hash, ng_hash_string(r->pose));
    return r->camera ? ng_hash_combine(hash, ng_hash_string(r->camera)) : hash;
}

static ng_result open_reference(struct job *job)
{
    const struct render *r = job->render;
    struct render_reference_params params = {.scene = r->scene,
                                             .world = job->stage->world,
                                             .strict = r->opening.loading.strict,
                                             .reference = {.width = r->size.width,
                                                           .height = r->size.height,
                                                           .depth = r->depth,
                                                           .sampler = (enum lf_sampler_kind)r->sampler,
                                                           .seed = r->seed,
                                                           .clamp = (float)r->clamp,
                                                           .antialias = r->antialias,
                                                           .jobs = job->stage->jobs},
                                             .samples = r->samples ? r->samples : DEFAULT_SAMPLES,
                                             .time_limit = r->time_limit,
                                             .checkpoint = r->resume,
                                             .picture = hash_picture(job)};
    return render_reference_create(&params, &job->reference);
}

// Makes the scene the sample that --variation names.
static ng_result vary(struct job *job)
{
    const struct render *r = job->render;
    struct lf_scene_sampler_params params = {.world = job->stage->world,
                                             .assets = job->stage->assets,
                                             .jobs = job->stage->jobs,
                                             .time = r->time,
                                             .camera = r->camera};
    struct lf_sample sample;
    job->time = r->time;
    if (!r->variation.given)
        return NG_OK;
    NG_TRY(lf_scene_sampler_create(&params, &job->sampler));
    NG_TRY(lf_scene_sampler_begin(job->sampler, r->variation.first, &sample));
    job->time = sample.time;
    return NG_OK;
}

// With --pose pictures are of another camera, like the one of the scene.
static ng_result choose_camera(struct job *job)
{
    const struct render *r = job->render;
    struct ng_world *world = job->stage->world;
    ng_entity root = job->stage->scene.root, model = job->stage->scene.camera;
    job->camera = r->camera;
    if (!r->pose)
        return NG_OK;
    if (r->camera)
        model = pose_find_camera(world, root, r->camera);
    struct ng_camera_controller c;
    NG_TRY(ng_stage_seek(job->stage, job->time, r->camera)); // which says if there is none
    if (!pose_look(world, root, model, &c))
        return NG_ERROR_NOT_FOUND;
    const struct ng_camera lens = *(const struct ng_camera *)ng_world_get(world, model, NG_CAMERA);
    const struct pose pose = pose_read(r->pose);
    pose_take(&pose, &c);
    const struct ng_free_camera camera = pose_camera(&c, &lens);
    ng_stage_look(job->stage, &camera);
    return NG_OK;
}

// Every file that a picture goes to: a sequence writes numbered ones only.
static ng_result each_output(const struct render *r, ng_result (*each)(void *user, const char *path),
                             void *user)
{
    for (uint32_t i = 0; i < r->outputs.count; i++) {
        if (!r->frames.given)
            NG_TRY(each(user, r->outputs.items[i]));
        for (uint32_t n = r->frames.first; r->frames.given && n <= r->frames.last; n++) {
            char path[4096];
            NG_TRY(number_path(r->outputs.items[i], n, path, sizeof path));
            NG_TRY(each(user, path));
        }
    }
    return NG_OK;
}

static ng_result add_output(void *user, const char *path)
{
    cli_files_write(user, "--output", path);
    return NG_OK;
}

// Weights beside the scene are its own whatever the method.
static ng_result find_files(struct job *job)
{
    const struct render *r = job->render;
    char weights[4096];
    cli_files_add_options(&job->files, &cli_render_command, r);
    if (lf_neural_find_weights(r->scene, weights, sizeof weights))
        cli_files_read(&job->files, "the weights beside SCENE", weights);
    for (uint32_t i = 0; i < r->clues.count; i++)
        cli_files_write(&job->files, "--clue", render_clue_file(r->clues.items[i]));
    return each_output(r, add_output, &job->files);
}

static void add_scene_file(void *user, const char *path)
{
    cli_files_read(user, "a file of SCENE", path);
}

static ng_result check_output(void *user, const char *path)
{
    NG_UNUSED(user);
    return ng_file_check_writable(path);
}

// That files cannot be written is better known before the work than after.
static ng_result check_outputs(const struct render *r)
{
    NG_TRY(each_output(r, check_output, NULL));
    if (r->graph)
        NG_TRY(ng_file_check_writable(r->graph));
    for (uint32_t i = 0; i < r->clues.count; i++)
        NG_TRY(ng_file_check_writable(render_clue_file(r->clues.items[i])));
    return r->resume ? ng_file_check_writable(r->resume) : NG_OK;
}

// Everything up to the point where the files are known. An exit code.
static int begin(struct job *job)
{
    const struct render *r = job->render;
    if (find_files(job) != NG_OK)
        return CLI_FAILED;
    if (!cli_files_check(&job->files, "render"))
        return CLI_USAGE;
    struct ng_stage_params params = {.scene = r->scene,
                                     .device = r->device,
                                     .threads = r->threads,
                                     .no_device = is_reference(r),
                                     .file = add_scene_file,
                                     .user = &job->files};
    opening_apply(&r->opening, &params);
    if (scene_file_check(r->scene) != NG_OK || check_outputs(r) != NG_OK ||
        ng_stage_create(&params, &job->stage) != NG_OK)
        return CLI_FAILED;
    return cli_files_check(&job->files, "render") ? CLI_DONE : CLI_USAGE;
}

static ng_result open_method(struct job *job)
{
    const struct render *r = job->render;
    return lf_method_create(&(struct lf_method_params){.name = lf_method_name(r->method),
                                                       .composer = ng_renderer_composer(job->stage->renderer),
                                                       .jobs = job->stage->jobs,
                                                       .scene = r->scene,
                                                       .weights = r->weights,
                                                       .gbuffer = (enum lf_raycast_use)r->gbuffer},
                            &job->method);
}

static ng_result render(struct job *job)
{
    const struct render *r = job->render;
    NG_TRY(vary(job));
    if (is_reference(r))
        NG_TRY(open_reference(job));
    else
        NG_TRY(open_method(job));
    choose_layers(job);
    render_clues_name(&r->clues, &job->clues);
    NG_TRY(choose_camera(job));
    NG_TRY(begin_motion(job));
    NG_TRY(r->frames.given ? render_sequence(job) : render_picture(job));
    if (r->graph)
        NG_TRY(write_graph(job, r->graph));
    if (r->clues.count)
        NG_TRY(render_clues_write(&r->clues, &job->clues, ng_renderer_graph(job->stage->renderer),
                                  lf_method_neural(job->method)));
    // The picture is there, but not all that was asked for.
    return render_reference_unsaved(job->reference) ? NG_ERROR_IO : NG_OK;
}

static int run(const void *args)
{
    struct render values = *(const struct render *)args;
    values.method = method_choose(method_option(values.method), values.scene, values.weights);
    struct job job = {.render = &values};
    if (!check_options(job.render))
        return CLI_USAGE;
    int code = begin(&job);
    cli_files_finish(&job.files);
    if (code == CLI_DONE && render(&job) != NG_OK)
        code = CLI_FAILED;
    render_reference_destroy(&job.reference);
    lf_method_destroy(&job.method);
    lf_scene_sampler_destroy(&job.sampler);
    render_middles_finish(&job.middles);
    ng_stage_destroy(&job.stage);
    return code;
}

bool render_canonical(const struct render_picture *p, char *out, size_t size)
{
    struct render r = {.scene = p->scene,
                       .weights = p->weights,
                       .pose = p->pose,
                       .size = p->size,
                       .time = p->time,
                       .method = lf_method_find(p->method),
                       .samples = p->samples,
                       .antialias = p->antialias,
                       .opening = p->opening};
    return cli_canonical(&cli_render_command, &r, out, size);
}

const struct cli_command cli_render_command = {
    .name = "render",
    .summary = "Renders a scene to pictures; no display is needed.",
    .notes = "--aov all: every layer that the method computes.\n"
             "--clue \"lamp/view.diffuse=x.exr\": what the network is given of a light; also pixel.normal, "
             "lamp/texel.flux,\n"
             "lamp/embedding.0. lightformer/net/inputs.inc lists all.\n"
             "--resume writes its file once a minute, at the end and at Ctrl-C (a second one ends at once): "
             "what is\n"
             "interrupted otherwise loses a minute at most.\n"
             "A sequence is numbered: -o out/chess.png --frames 0..59 writes out/chess.0000.png to "
             "out/chess.0059.png.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct render),
    .run = run,
};
