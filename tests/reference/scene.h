// Small scenes for tests of rays and light, made from the engine's own components, so that what a test traces
// went through extraction as every scene does.
//
//     struct scene s;
//     scene_open(&s, 2);
//     scene_quad(&s, corner, u, v, scene_material(&s, grey, 0, 1));
//     scene_light(&s, NG_LIGHT_POINT, &light, position, NULL);
//     scene_frame(&s, 0);                      // world -> snapshot -> tracer
//     ...
//     scene_close(&s);
#ifndef NG_TESTS_REFERENCE_SCENE_H
#define NG_TESTS_REFERENCE_SCENE_H

#include "test.h"

#include "asset/assets.h"
#include "components/components.h"
#include "lightformer/reference/path.h"
#include "lightformer/reference/reference.h"
#include "render/snapshot.h"

#define NEAR(a, b, e) assert_true(fabs((double)(a) - (double)(b)) <= (double)(e))
#define OK(call)      assert_int_equal((call), NG_OK)

struct ng_extractor;
struct ng_jobs;
struct ng_world;

struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_jobs *jobs;
    struct ng_extractor *extractor;
    struct lf_tracer *tracer;
    const struct ng_snapshot *snapshot;
    struct lf_light_choice lights;
    ng_entity camera; // at (0, 0, 5), looking along -Z
    ng_entity scale;  // radius 3
};

void scene_open(struct scene *s, uint32_t threads);
void scene_load(struct scene *s, uint32_t threads, const char *path); // a glTF file instead
void scene_close(struct scene *s);
void scene_frame(struct scene *s, double time);
// The same, where one warning is expected: a material emits and is no light.
void scene_frame_warned(struct scene *s, double time);

// Rotations are quaternions; null: none.
ng_entity scene_entity(struct scene *s, const char *name, const float position[3], const float rotation[4]);
ng_entity scene_material(struct scene *s, const float base[3], float metallic, float roughness);
// Black, and emits `radiance`.
ng_entity scene_glow(struct scene *s, const float radiance[3]);
// A parallelogram that faces along u x v.
ng_entity scene_quad(struct scene *s, const float corner[3], const float u[3], const float v[3],
                     ng_entity material);
// A sphere of many triangles with smooth normals; `inside`: it faces inwards.
ng_entity scene_sphere(struct scene *s, const float center[3], float radius, bool inside, ng_entity material);
ng_entity scene_light(struct scene *s, ng_component type, const void *light, const float position[3],
                      const float rotation[4]);
extern const float scene_down[4]; // turns -Z, where lights shine, to -Y
// White.
ng_entity scene_point(struct scene *s, float intensity, const float position[3]);
ng_entity scene_sky(struct scene *s); // of radiance 1

// ---- estimates -------------------------------------------------------------------------------------------
struct estimate {
    double mean, error; // of the mean, one standard deviation
};

// Mean of the three channels of a split radiance, `samples` paths of at most `depth` segments from a primary
// hit. `part` chooses: offset of a member of struct lf_radiance.
struct estimate scene_estimate(const struct scene *s, const struct lf_primary *primary, uint32_t samples,
                               uint32_t depth, enum lf_sampler_kind kind, uint64_t seed, size_t part);
// A primary hit of a white Lambertian surface, seen from straight above.
struct lf_primary scene_receiver(const float position[3], const float normal[3]);
// Radiance of such a surface times pi is its irradiance, but for Fresnel, at most 0.2 %.
#define scene_irradiance(s, position, normal, samples, part)                                                 \
    scene_irradiance_((s), (position), (normal), (samples), offsetof(struct lf_radiance, part))
struct estimate scene_irradiance_(const struct scene *s, const float position[3], const float normal[3],
                                  uint32_t samples, size_t part);
// Within `sigmas` standard deviations, and the estimate is not idle: its error is below `error` * value.
#define ESTIMATES(e, value, bias, error_)                                                                    \
    do {                                                                                                     \
        struct estimate e_ = (e);                                                                            \
        double v_ = (value);                                                                                 \
        if (fabs(e_.mean - v_) > 4.5 * e_.error + (bias)*fabs(v_) || e_.error > (error_)*fabs(v_))           \
            fail_msg("line %d: %.7g +- %.2g, but should be %.7g (%.1f sigma)", __LINE__, e_.mean, e_.error,  \
                     v_, (e_.mean - v_) / fmax(e_.error, 1e-30));                                            \
    } while (0)

// Renders; layers are fetched from it. The caller destroys it.
struct lf_reference *scene_render(const struct scene *s, const struct lf_reference_params *params,
                                  uint32_t samples);
float *scene_layer(const struct lf_reference *reference, const char *name); // free()
// Renders, and keeps one layer. free() it.
float *scene_render_layer(const struct scene *s, const struct lf_reference_params *params, uint32_t samples,
                          const char *name);

#endif
