// Cameras are judged by rays. An eye stands inside of a thing if what it sees in some direction is a back;
// and a view shows something if its middle and most of what is around meet a surface, none of them too near.
#include "lightformer/dataset/sampler.h"

#include "base/log.h"
#include "components/components.h"
#include "lightformer/dataset/variations.h"
#include "lightformer/reference/check.h"
#include "lightformer/trace/tracer.h"
#include "render/extract.h"
#include "scene/history.h"
#include "scene/system.h"

#include <cglm/cglm.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define ROOM_SHARE 0.01f // of the scene's radius: free space around an eye
#define VIEW_SHARE 0.05f // of the scene's radius: nearest thing in the middle of a view

struct lf_scene_sampler {
    struct lf_scene_sampler_params params;
    struct lf_variations *variations;
    struct ng_extractor *extractor;
    struct lf_tracer *tracer;
    const struct ng_snapshot *snapshot;
};

// ---- views -----------------------------------------------------------------------------------------------

static ng_result take_snapshot(struct lf_scene_sampler *self, double time)
{
    struct ng_extract_params params = {
        .world = self->params.world,
        .assets = self->params.assets,
        .jobs = self->params.jobs,
        .time = time,
        .camera = self->params.camera,
        .still = true,
    };
    NG_TRY(ng_extract(self->extractor, &params, &self->snapshot));
    return lf_tracer_update(self->tracer, self->snapshot);
}

static bool is_back(const struct ng_snapshot *s, const struct lf_hit *hit)
{
    return !hit->front && !(s->instances[hit->instance].flags & NG_INSTANCE_DOUBLE_SIDED);
}

// Looks around: 26 directions.
static bool is_free(const struct lf_scene_sampler *self, const float eye[3])
{
    for (int i = 0; i < 27; i++) {
        int x = i % 3 - 1, y = i / 3 % 3 - 1, z = i / 9 - 1;
        vec3 direction = {(float)x, (float)y, (float)z};
        struct lf_ray ray = {.far = INFINITY};
        struct lf_hit hit;
        if (i == 13)
            continue;
        glm_vec3_normalize_to(direction, ray.direction);
        glm_vec3_copy((float *)eye, ray.origin);
        if (lf_trace_closest(self->tracer, &ray, LF_RAY_ALL, &hit) &&
            (is_back(self->snapshot, &hit) || hit.distance < ROOM_SHARE * self->snapshot->scene_radius))
            return false;
    }
    return true;
}

// Five rays: the middle, and half way to the corners of a view of about 60 degrees.
static bool shows_something(const struct lf_scene_sampler *self, const float eye[3], const float forward[3])
{
    vec3 right, up;
    int met = 0;
    glm_vec3_crossn((float *)forward, GLM_YUP, right);
    glm_vec3_cross(right, (float *)forward, up);
    for (int i = 0; i < 5; i++) {
        struct lf_ray ray = {.far = INFINITY};
        struct lf_hit hit;
        glm_vec3_copy((float *)eye, ray.origin);
        glm_vec3_copy((float *)forward, ray.direction);
        if (i) {
            glm_vec3_muladds(right, i & 1 ? 0.3f : -0.3f, ray.direction);
            glm_vec3_muladds(up, i & 2 ? 0.3f : -0.3f, ray.direction);
            glm_vec3_normalize(ray.direction);
        }
        bool hits = lf_trace_closest(self->tracer, &ray, LF_RAY_CAMERA, &hit);
        if (i == 0 && (!hits || hit.distance < VIEW_SHARE * self->snapshot->scene_radius))
            return false;
        met += hits;
    }
    return met >= 3;
}

static ng_result judge(void *user, double time, uint32_t candidate, const float eye[3],
                       const float forward[3], bool *good)
{
    struct lf_scene_sampler *self = user;
    if (candidate == 0)
        NG_TRY(take_snapshot(self, time));
    *good = is_free(self, eye) && shows_something(self, eye, forward);
    return NG_OK;
}

// ---- samples ---------------------------------------------------------------------------------------------

static bool has_camera(const struct ng_world *world)
{
    for (ng_entity e = ng_world_first_child(world, (ng_entity){0}); !ng_entity_is_null(e);
         e = ng_world_next_sibling(world, e))
        for (ng_entity b = e; !ng_entity_is_null(b); b = ng_world_next_below(world, e, b))
            if (ng_world_has(world, b, NG_CAMERA))
                return true;
    return false;
}

static ng_result open_parts(struct lf_scene_sampler *self)
{
    if (!has_camera(self->params.world)) {
        ng_log_error("the scene has no camera; add one to make samples of it");
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(lf_variations_create(self->params.world, &self->variations));
    if (lf_variations_count(self->variations) == 0) {
        ng_log_error("nothing varies in this scene: all samples would be equal; add variation components");
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(ng_extractor_create(&self->extractor));
    return lf_tracer_create(&self->tracer);
}

ng_result lf_scene_sampler_create(const struct lf_scene_sampler_params *params, struct lf_scene_sampler **out)
{
    *out = NULL;
    struct lf_scene_sampler *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("a scene's samples");
    self->params = *params;
    ng_result result = open_parts(self);
    if (result != NG_OK)
        lf_scene_sampler_destroy(&self);
    *out = self;
    return result;
}

void lf_scene_sampler_destroy(struct lf_scene_sampler **sampler)
{
    struct lf_scene_sampler *self = *sampler;
    *sampler = NULL;
    if (!self)
        return;
    lf_tracer_destroy(&self->tracer);
    ng_extractor_destroy(&self->extractor);
    lf_variations_destroy(&self->variations);
    free(self);
}

// Emission alone is no light: encoders observe lights.
static ng_result check_scene(const struct lf_scene_sampler *self, uint64_t seed)
{
    const struct ng_snapshot *s = self->snapshot;
    char sample[64];
    bool shines = false;
    snprintf(sample, sizeof sample, "the sample of seed %" PRIu64, seed);
    NG_TRY(lf_check_scene(self->params.world, s, sample, LF_CHECK_REFUSE));
    for (uint32_t i = 0; i < s->light_count; i++)
        shines |= s->lights[i].power > 0;
    if (shines)
        return NG_OK;
    ng_log_error("%s: no light shines; add a light component, or switch one on", sample);
    return NG_ERROR_FORMAT;
}

ng_result lf_scene_sampler_begin(struct lf_scene_sampler *self, uint64_t seed, struct lf_sample *out)
{
    struct lf_variations_apply_params params = {
        .seed = seed, .time = self->params.time, .judge = judge, .user = self};
    *out = (struct lf_sample){.seed = seed, .tracer = self->tracer};
    NG_TRY(lf_variations_apply(self->variations, &params, &out->time));
    ng_result result = take_snapshot(self, out->time);
    if (result == NG_OK)
        result = check_scene(self, seed);
    out->snapshot = self->snapshot;
    if (result != NG_OK && lf_scene_sampler_end(self) != NG_OK)
        return NG_ERROR_MEMORY;
    return result;
}

ng_result lf_scene_sampler_end(struct lf_scene_sampler *self)
{
    NG_TRY(ng_world_undo(self->params.world));
    return ng_world_run(self->params.world, self->params.time);
}
