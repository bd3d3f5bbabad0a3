// A renderer of its own, in which a provider asks for the resources of the passes that the encoders will
// join. Nothing asks for the method's picture, so the graph leaves those passes out.
#include "lightformer/dataset/capture.h"

#include "base/array.h"
#include "base/log.h"
#include "gpu/frame.h"
#include "render/frame.h"
#include "render/light_gpu.h"
#include "render/renderer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct lf_capture {
    struct ng_gpu *gpu;
    struct ng_renderer *renderer;
    bool pixels_only;                    // this frame
    NG_ARRAY(struct ng_light_maps) maps; // of the frame; names belong to the light maps' provider
    NG_ARRAY(struct lf_captured_light) lights;
    NG_ARRAY(struct ng_light_sample) vpls;
};

static const char *const gbuffer_names[] = {"gbuffer/position", "gbuffer/normal", "gbuffer/diffuse",
                                            "gbuffer/specular", "gbuffer/emission"};

enum map { DEPTH, POSITION, NORMAL, FLUX, MAPS };

static void map_name(const struct ng_light_maps *maps, enum map map, char out[160])
{
    static const char *const names[MAPS] = {"depth", "position", "normal", "flux"};
    snprintf(out, 160, "rsm:%s/%s", maps->name, names[map]);
}

static ng_result ask(struct ng_composer *composer, void *user)
{
    struct lf_capture *self = user;
    struct ng_graph *graph = ng_composer_graph(composer);
    self->maps.count = 0;
    for (size_t i = 0; i < NG_COUNT(gbuffer_names); i++)
        ng_graph_readback(graph, gbuffer_names[i]);
    for (size_t i = 0; !self->pixels_only && i < ng_composer_count(composer, &ng_light_maps_item); i++) {
        const struct ng_light_maps *maps = ng_composer_get(composer, &ng_light_maps_item, i);
        char name[160];
        if (!ng_array_push(&self->maps, *maps))
            return ng_out_of_memory("the observation of a frame");
        for (int m = 0; m < MAPS; m++) {
            map_name(maps, (enum map)m, name);
            ng_graph_readback(graph, name);
        }
    }
    return NG_OK;
}

ng_result lf_capture_create(struct ng_gpu *gpu, struct ng_jobs *jobs, struct lf_capture **out)
{
    *out = NULL;
    struct lf_capture *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the observation of a frame");
    self->gpu = gpu;
    struct ng_renderer_params params = {.gpu = gpu, .jobs = jobs};
    struct ng_provider provider = {.name = "observer", .consume = ask, .user = self};
    ng_result result = ng_renderer_create(&params, &self->renderer);
    if (result == NG_OK)
        result = ng_composer_register(ng_renderer_composer(self->renderer), &provider);
    if (result != NG_OK)
        lf_capture_destroy(&self);
    *out = self;
    return result;
}

void lf_capture_destroy(struct lf_capture **observer)
{
    struct lf_capture *self = *observer;
    *observer = NULL;
    if (!self)
        return;
    ng_renderer_destroy(&self->renderer);
    ng_array_finish(&self->maps);
    ng_array_finish(&self->lights);
    ng_array_finish(&self->vpls);
    free(self);
}

static ng_result draw(struct lf_capture *self, const struct lf_capture_params *p)
{
    struct ng_render_params params = {.snapshot = p->snapshot, .width = p->width, .height = p->height};
    struct ng_cmd *cmd;
    NG_TRY(ng_frame_begin(self->gpu, &cmd));
    ng_result drawn = ng_renderer_frame(self->renderer, &cmd, &params);
    ng_result ended = ng_frame_end(self->gpu, &cmd);
    return drawn != NG_OK ? drawn : ended;
}

static ng_result fetch(const struct lf_capture *self, const char *name, const void **data)
{
    struct ng_graph_memory memory;
    NG_TRY(ng_graph_readback_get(ng_renderer_graph(self->renderer), name, &memory));
    *data = memory.data;
    return NG_OK;
}

static ng_result fetch_gbuffer(const struct lf_capture *self, struct lf_gbuffer *out)
{
    const void *data[NG_COUNT(gbuffer_names)];
    for (size_t i = 0; i < NG_COUNT(gbuffer_names); i++)
        NG_TRY(fetch(self, gbuffer_names[i], &data[i]));
    *out = (struct lf_gbuffer){data[0], data[1], data[2], data[3], data[4]};
    return NG_OK;
}

static ng_result fetch_light(const struct lf_capture *self, const struct ng_light_maps *maps,
                             struct lf_captured_light *out)
{
    const void *data[MAPS];
    for (int m = 0; m < MAPS; m++) {
        char name[160];
        map_name(maps, (enum map)m, name);
        NG_TRY(fetch(self, name, &data[m]));
    }
    *out = (struct lf_captured_light){
        .light = maps->light,
        .data = maps->gpu->data,
        .rsm_views = maps->rsm_views,
        .position = data[POSITION],
        .normal = data[NORMAL],
        .flux = data[FLUX],
        .depth_views = maps->depth_views,
        .face_size = maps->face_size,
        .depth = data[DEPTH],
    };
    return NG_OK;
}

static ng_result fetch_lights(struct lf_capture *self, const struct ng_snapshot *s, uint32_t vpl_count)
{
    size_t count = self->maps.count;
    if (!ng_array_resize(&self->lights, count) || !ng_array_resize(&self->vpls, count * vpl_count)) {
        ng_log_error("out of memory for %u direct VPLs of each of %zu lights", vpl_count, count);
        return NG_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        struct lf_captured_light *light = &self->lights.items[i];
        NG_TRY(fetch_light(self, &self->maps.items[i], light));
        const struct ng_light_source *source = &s->lights[light->light].source;
        light->vpls = self->vpls.items + i * vpl_count;
        ng_light_vpls(source, vpl_count, light->vpls);
        ng_light_power_rgb(source, light->power);
    }
    return NG_OK;
}

ng_result lf_capture_frame(struct lf_capture *self, const struct lf_capture_params *p,
                           struct lf_captured_frame *out)
{
    if (p->snapshot->camera.orthographic) {
        ng_log_error(
            "data sets are of perspective cameras: this one is orthographic; choose another with --camera");
        return NG_ERROR_UNSUPPORTED;
    }
    *out = (struct lf_captured_frame){
        .width = p->width, .height = p->height, .vpl_count = p->vpl_count ? p->vpl_count : LF_VPL_COUNT};
    self->pixels_only = p->pixels_only;
    NG_TRY(draw(self, p));
    NG_TRY(fetch_gbuffer(self, &out->gbuffer));
    NG_TRY(fetch_lights(self, p->snapshot, out->vpl_count));
    out->light_count = (uint32_t)self->lights.count;
    out->lights = self->lights.items;
    memcpy(out->eye, p->snapshot->camera.position, sizeof out->eye);
    return NG_OK;
}
