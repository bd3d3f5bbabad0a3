// What each part of an encoding depends on: hashes of all that it is made from.
#include "lightformer/encode/encoder_internal.h"

#include "base/hash.h"
#include "render/light_gpu.h"
#include "render/scene_gpu.h"

#include <math.h>
#include <string.h>

static bool reads(const struct lf_encoder *self, enum lf_net_input input)
{
    return self->reads >> input & 1;
}

static uint64_t nonzero(uint64_t hash)
{
    return hash ? hash : 1;
}

uint64_t lf_encoder_screen_key(const struct lf_encoder *self, const struct ng_frame_info *frame)
{
    const struct ng_snapshot *s = frame->snapshot;
    const float numbers[] = {s->camera.fov_y,       s->camera.near_plane,  s->scene_radius,
                             s->scene_center[0],    s->scene_center[1],    s->scene_center[2],
                             s->camera.position[0], s->camera.position[1], s->camera.position[2],
                             s->place_size};
    const uint64_t words[] = {s->geometry_version, frame->width, frame->height};
    uint64_t hash = ng_hash_bytes(0, words, sizeof words);
    hash = ng_hash_bytes(hash, numbers, sizeof numbers);
    hash = ng_hash_bytes(hash, s->camera.view, sizeof s->camera.view);
    if (reads(self, LF_INPUT_PIXEL_MIRROR_EMISSION))
        hash = ng_hash_combine(hash, s->emission_version);
    return nonzero(hash);
}

// What rays into a view may meet. Those of a perspective begin at the light, not at its near plane.
static uint64_t hash_met(const struct ng_frame_info *frame, const struct ng_light_gpu *l, uint32_t view,
                         uint32_t light)
{
    float m[16];
    memcpy(m, l->rsm_views[view].view_projection, sizeof m);
    if (!l->data.window_count)
        m[14] = 0; // the near plane's distance
    return ng_scene_gpu_seen(frame->scene, m, light);
}

uint64_t lf_encoder_rsm_key(const struct ng_frame_info *frame, uint32_t light)
{
    const struct ng_snapshot *s = frame->snapshot;
    struct ng_snapshot_light unit = s->lights[light];
    ng_light_unit(&s->lights[light].source, &unit.source);
    struct ng_snapshot alone = *s;
    alone.lights = &unit;
    alone.light_count = 1;
    struct ng_light_gpu views;
    ng_light_gpu_observe(&alone, 0, 1, INFINITY, &views);

    uint64_t hash = ng_hash_bytes(unit.unit_version, &s->place_size, sizeof s->place_size);
    for (uint32_t v = 0; v < views.rsm_view_count; v++)
        hash = ng_hash_combine(hash, hash_met(frame, &views, v, light));
    return nonzero(hash);
}

uint64_t lf_encoder_points_key(const struct lf_encoder *self, const struct ng_snapshot *s,
                               const struct lf_shining *light)
{
    uint64_t hash = light->rsm_key;
    if (reads(self, LF_INPUT_LIGHT_POWER))
        hash = ng_hash_combine(hash, s->lights[light->maps->light].version);
    for (uint32_t i = 0; i < s->light_count && reads(self, LF_INPUT_FRAME_MEAN_POWER); i++)
        hash = ng_hash_bytes(hash, &s->lights[i].power, sizeof s->lights[i].power);
    return nonzero(hash);
}

uint64_t lf_encoder_powers_key(const struct lf_encoder *self, const struct ng_snapshot *s, uint64_t screen)
{
    uint64_t hash = screen;
    for (uint32_t i = 0; i < s->light_count; i++)
        hash = ng_hash_bytes(hash, &s->lights[i].power, sizeof s->lights[i].power);
    for (size_t i = 0; i < self->shining.count; i++)
        hash = ng_hash_combine(hash, self->shining.items[i].points_key);
    return nonzero(hash);
}
