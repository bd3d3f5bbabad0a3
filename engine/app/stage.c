// A frame is four steps: the world moves, a snapshot is taken of it, the renderer draws the snapshot, the
// window shows the result.
#include "app/stage.h"

#include "app/window.h"
#include "asset/assets.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/system.h"
#include "components/components.h"
#include "gpu/frame.h"
#include "gpu/swapchain.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <stdlib.h>

struct ng_stage_internal {
    struct ng_window *window;
    struct ng_extractor *extractor;
    struct ng_swapchain *swapchain;
    struct ng_exposure exposure;
    bool drawn; // a frame before this one has been extracted
    bool looks; // through `camera`
    struct ng_free_camera camera;
};

static ng_result load_scene(struct ng_stage *stage, const struct ng_stage_params *params)
{
    struct ng_jobs_params jobs = {.threads = params->threads};
    struct ng_gltf_params gltf = {.default_light = !params->no_default_light,
                                  .emissive_lights = params->emissive_lights,
                                  .clip = params->clip,
                                  .strict = params->strict,
                                  .max_memory = params->max_memory,
                                  .file = params->file,
                                  .user = params->user};
    NG_TRY(ng_jobs_create(&jobs, &stage->jobs));
    NG_TRY(ng_assets_create(&stage->assets));
    NG_TRY(ng_world_create(NULL, &stage->world));
    NG_TRY(ng_components_register(stage->world));
    NG_TRY(ng_scene_systems_add(stage->world, stage->assets, stage->jobs));
    return ng_gltf_load(params->scene, stage->world, stage->assets, &gltf, &stage->scene);
}

static ng_result open_renderer(struct ng_stage *stage, const struct ng_stage_params *params)
{
    struct ng_renderer_params renderer = {
        .gpu = stage->gpu,
        .jobs = stage->jobs,
        .redraw_lights = params->redraw_lights,
        .bare_passes = params->bare_passes,
    };
    return ng_renderer_create(&renderer, &stage->renderer);
}

static ng_result open_device(struct ng_stage *stage, const struct ng_stage_params *params)
{
    struct ng_gpu_params gpu = {.device = params->device};
    if (params->window)
        gpu.instance_extensions = ng_window_extensions(&gpu.instance_extension_count);
    NG_TRY(ng_gpu_create(&gpu, &stage->gpu));
    return open_renderer(stage, params);
}

static ng_result open_window(struct ng_stage *stage, struct ng_window *window)
{
    struct ng_swapchain_params params = {.width = window->width, .height = window->height};
    NG_TRY(ng_window_create_surface(window, stage->gpu->instance, &params.surface));
    stage->internal->window = window;
    return ng_swapchain_create(stage->gpu, &params, &stage->internal->swapchain);
}

ng_result ng_stage_create(const struct ng_stage_params *params, struct ng_stage **out)
{
    *out = NULL;
    NG_REQUIRE(params->scene, "a stage needs a scene");
    struct ng_stage *stage = calloc(1, sizeof *stage);
    struct ng_stage_internal *internal = calloc(1, sizeof *internal);
    if (!stage || !internal) {
        ng_log_error("%s: out of memory", params->scene);
        free(stage);
        free(internal);
        return NG_ERROR_MEMORY;
    }
    stage->internal = internal;
    internal->exposure = params->exposure;
    ng_result result = load_scene(stage, params);
    if (result == NG_OK)
        result = ng_extractor_create(&internal->extractor);
    if (result == NG_OK && !params->no_device)
        result = open_device(stage, params);
    if (result == NG_OK && params->window)
        result = open_window(stage, params->window);
    if (result != NG_OK) {
        ng_stage_destroy(&stage);
        return result;
    }
    *out = stage;
    return NG_OK;
}

void ng_stage_destroy(struct ng_stage **stage)
{
    struct ng_stage *s = *stage;
    if (!s)
        return;
    *stage = NULL;
    struct ng_stage_internal *internal = s->internal;
    ng_renderer_destroy(&s->renderer);
    ng_swapchain_destroy(&internal->swapchain);
    if (internal->window)
        ng_window_destroy_surface(internal->window);
    ng_gpu_destroy(&s->gpu);
    ng_extractor_destroy(&internal->extractor);
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
    ng_jobs_destroy(&s->jobs);
    free(internal);
    free(s);
}

ng_result ng_stage_adopt(struct ng_stage *stage, struct ng_stage **next)
{
    struct ng_stage *n = *next;
    NG_REQUIRE(stage->gpu && !n->gpu, "a stage with a device adopts one without");
    ng_renderer_destroy(&stage->renderer);
    struct ng_stage old = *stage;
    struct ng_extractor *extractor = stage->internal->extractor;
    stage->jobs = n->jobs, n->jobs = old.jobs;
    stage->assets = n->assets, n->assets = old.assets;
    stage->world = n->world, n->world = old.world;
    stage->scene = n->scene;
    stage->internal->extractor = n->internal->extractor, n->internal->extractor = extractor;
    stage->internal->drawn = stage->internal->looks = false;
    stage->snapshot = NULL;
    ng_stage_destroy(next);
    return open_renderer(stage, &(struct ng_stage_params){0});
}

void ng_stage_look(struct ng_stage *stage, const struct ng_free_camera *camera)
{
    stage->internal->looks = camera != NULL;
    if (camera)
        stage->internal->camera = *camera;
}

static ng_result move_to(struct ng_stage *stage, double time, const char *camera, bool still,
                         uint32_t subpixel)
{
    struct ng_stage_internal *internal = stage->internal;
    uint64_t start_ns = ng_clock_ns();
    NG_TRY(ng_world_run(stage->world, time));
    uint64_t extract_ns = ng_clock_ns();
    struct ng_extract_params params = {
        .world = stage->world,
        .assets = stage->assets,
        .jobs = stage->jobs,
        .time = time,
        .camera = camera,
        .free_camera = internal->looks ? &internal->camera : NULL,
        .exposure = internal->exposure,
        .subpixel = subpixel,
        .still = still || !internal->drawn,
    };
    NG_TRY(ng_extract(internal->extractor, &params, &stage->snapshot));
    internal->drawn = true;
    stage->world_ms = (double)(extract_ns - start_ns) * 1e-6;
    stage->extract_ms = (double)(ng_clock_ns() - extract_ns) * 1e-6;
    return NG_OK;
}

ng_result ng_stage_seek(struct ng_stage *stage, double time, const char *camera)
{
    return move_to(stage, time, camera, true, 0);
}

ng_result ng_stage_advance(struct ng_stage *stage, double time, const char *camera)
{
    return move_to(stage, time, camera, false, 0);
}

// One frame of the device. What was begun is ended, whatever fails in between.
static ng_result submit(struct ng_stage *stage, struct ng_render_params *params)
{
    struct ng_swapchain *swapchain = stage->internal->swapchain;
    struct ng_cmd *cmd;
    NG_TRY(ng_frame_begin(stage->gpu, &cmd));
    ng_result drawn = swapchain ? ng_swapchain_acquire(swapchain, &params->target) : NG_OK;
    if (drawn == NG_OK)
        drawn = ng_renderer_frame(stage->renderer, &cmd, params);
    ng_result ended = ng_frame_end(stage->gpu, &cmd);
    ng_result shown = swapchain && ended == NG_OK ? ng_swapchain_present(swapchain) : NG_OK;
    return drawn != NG_OK ? drawn : ended != NG_OK ? ended : shown;
}

ng_result ng_stage_draw(struct ng_stage *stage, const struct ng_stage_frame *frame)
{
    const struct ng_window *window = stage->internal->window;
    struct ng_render_params params = {
        .width = frame->width || !window ? frame->width : window->width,
        .height = frame->height || !window ? frame->height : window->height,
        .light_width = frame->light_width,
        .light_height = frame->light_height,
        .method = frame->method,
        .shown = frame->shown,
        .layers = frame->layers,
        .layer_count = frame->layer_count,
        .resources = frame->resources,
        .resource_count = frame->resource_count,
        .overlay = frame->overlay,
        .overlay_user = frame->overlay_user,
        .adaptation = frame->adaptation,
        .averaged = frame->averaged,
        .abandon = frame->abandon,
        .abandon_user = frame->abandon_user,
    };
    NG_REQUIRE(stage->renderer, "the stage was made without a device");
    NG_REQUIRE(window || (params.width && params.height), "a frame without a window needs a size");
    if (params.width == 0 || params.height == 0)
        return NG_OK;
    uint32_t subpixel = frame->averaged ? frame->averaged - 1 : 0;
    NG_TRY(move_to(stage, frame->time, frame->camera, frame->still, subpixel));
    params.snapshot = stage->snapshot;
    if (window)
        ng_swapchain_resize(stage->internal->swapchain, window->width, window->height);
    return submit(stage, &params);
}
