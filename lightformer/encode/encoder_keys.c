// What each pass depends on besides what it reads.
#include "lightformer/encode/encoder_internal.h"

#include "graph/key.h"
#include "lightformer/clues/interleaved.h"
#include "render/light_gpu.h"
#include "render/scene_gpu.h"

#include <math.h>
#include <string.h>

static bool reads(const struct lf_encoder *self, enum lf_net_input input)
{
    return self->reads >> input & 1;
}

uint64_t lf_encoder_pixels_key(const struct lf_encoder *self, const struct ng_frame_info *frame)
{
    const struct ng_snapshot *s = frame->snapshot;
    const float numbers[] = {s->camera.fov_y,       s->camera.height,      s->camera.near_plane,
                             s->scene_radius,       s->scene_center[0],    s->scene_center[1],
                             s->scene_center[2],    s->camera.position[0], s->camera.position[1],
                             s->camera.position[2], s->place_size};
    const uint64_t words[] = {s->surface_version, frame->width, frame->height, s->camera.subpixel};
    uint64_t key = ng_key_add_bytes(NG_KEY, words, sizeof words);
    key = ng_key_add_bytes(key, numbers, sizeof numbers);
    key = ng_key_add_bytes(key, s->camera.view, sizeof s->camera.view);
    return self->reads & LF_ARRIVING_INPUTS ? ng_key_add(key, s->emission_version) : key;
}

// What rays into a view may meet. Those of a perspective begin at the light, not at its near plane.
static uint64_t key_of_view(const struct lf_encoder *self, const struct ng_frame_info *frame,
                            const struct ng_light_gpu *l, uint32_t view)
{
    // A texel of a map may look past the edge; rays pass lamps that are beside the light.
    struct ng_seen_params params = {.skip_light = l->data.index,
                                    .not_beside = self->params.rsm != LF_RSM_MAPS};
    memcpy(params.view_projection, l->rsm_views[view].view_projection, sizeof params.view_projection);
    if (!l->data.window_count)
        params.view_projection[14] = 0; // the near plane's distance
    return ng_scene_gpu_seen(frame->scene, &params);
}

uint64_t lf_encoder_rsm_key(const struct lf_encoder *self, const struct ng_frame_info *frame,
                            const struct lf_active_light *light)
{
    const struct ng_snapshot *s = frame->snapshot;
    const struct ng_snapshot_light *l = &s->lights[light->maps->light];
    const struct ng_light_gpu *views = light->maps->gpu;

    // Buffers belong to a name, and what they refer to belongs to a light.
    uint64_t key = ng_key_add_bytes(NG_KEY, light->kept->type->name, strlen(light->kept->type->name));
    key = ng_key_add(ng_key_add(key, l->entity.id), l->unit_version);
    key = ng_key_add(key, lf_questions_of(s->light_count) == LF_ASK_FEW);
    if (self->params.rsm == LF_RSM_MAPS) // their flux is that of the light as it is, divided by its power
        key = ng_key_add(key, l->version);
    const float space[] = {s->scene_radius, s->scene_center[0], s->scene_center[1], s->scene_center[2],
                           s->place_size};
    key = ng_key_add_bytes(key, space, sizeof space);
    for (uint32_t v = 0; v < views->rsm_view_count; v++)
        key = ng_key_add(key, key_of_view(self, frame, views, v));
    return key;
}

uint64_t lf_encoder_clues_key(const struct ng_snapshot *s)
{
    return ng_key_add(NG_KEY, lf_questions_of(s->light_count));
}

uint64_t lf_encoder_light_key(const struct lf_encoder *self, const struct ng_snapshot *s, uint32_t light)
{
    uint64_t key = NG_KEY;
    if (reads(self, LF_INPUT_LIGHT_POWER))
        key = ng_key_add(key, s->lights[light].version);
    return reads(self, LF_INPUT_FRAME_MEAN_POWER) ? ng_key_add(key, lf_encoder_powers_key(s)) : key;
}

uint64_t lf_encoder_powers_key(const struct ng_snapshot *s)
{
    uint64_t key = NG_KEY;
    for (uint32_t i = 0; i < s->light_count; i++)
        key = ng_key_add_bytes(key, &s->lights[i].power, sizeof s->lights[i].power);
    return key;
}
