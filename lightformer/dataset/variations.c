// Checking and drawing walk the same list: an item is a variation with its field found. A value is drawn into
// doubles, stored as the field's type, and checked by the field's own rule before the world gets it.
#include "lightformer/dataset/variations.h"

#include "base/array.h"
#include "base/log.h"
#include "base/rng.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/name.h"
#include "components/placement.h"
#include "components/transform.h"
#include "components/variation.h"
#include "scene/history.h"
#include "scene/query.h"
#include "scene/system.h"

#include <cglm/cglm.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define CAMERA_TRIES 256

// The largest value of a field that is drawn.
union value {
    float reals[4];
    int32_t signed_number;
    uint32_t number;
    bool boolean;
};

struct item {
    ng_entity entity; // of the variation
    struct ng_variation v;
    struct ng_field_ref field; // null for time and cameras
    union value set;           // what the sample under way gave the field
};

struct lf_variations {
    struct ng_world *world;
    NG_ARRAY(struct item) items;
};

static const char *name_of(const struct lf_variations *self, ng_entity e)
{
    const struct ng_name *name = ng_world_get(self->world, e, NG_NAME);
    return name && name->text[0] ? name->text : "unnamed";
}

#define REFUSE(self, item, result, format, ...)                                                              \
    (ng_log_error("variation \"%s\": " format, name_of((self), (item)->entity), __VA_ARGS__), (result))

// ---- fields ----------------------------------------------------------------------------------------------

// Numbers that a field is drawn as; 0: not at all.
static int channels_of(enum ng_field_type type)
{
    switch (type) {
    case NG_FIELD_BOOL:
    case NG_FIELD_I32:
    case NG_FIELD_U32:
    case NG_FIELD_ENUM:
    case NG_FIELD_F32:
        return 1;
    case NG_FIELD_VEC2:
        return 2;
    case NG_FIELD_VEC3:
    case NG_FIELD_COLOR:
        return 3;
    case NG_FIELD_VEC4:
    case NG_FIELD_QUAT:
        return 4;
    default:
        return 0;
    }
}

static bool is_real(enum ng_field_type type)
{
    return type == NG_FIELD_F32 || type == NG_FIELD_COLOR || channels_of(type) > 1;
}

// False if the number has no place in the type.
static bool store(enum ng_field_type type, const double channels[4], union value *out)
{
    double x = channels[0];
    *out = (union value){0};
    if (is_real(type)) {
        for (int i = 0; i < channels_of(type); i++)
            out->reals[i] = (float)channels[i];
        return true;
    }
    if (x != floor(x))
        return false;
    if (type == NG_FIELD_BOOL)
        out->boolean = x != 0;
    else if (type == NG_FIELD_I32 && fabs(x) <= INT32_MAX)
        out->signed_number = (int32_t)x;
    else if (x >= 0 && x <= UINT32_MAX)
        out->number = (uint32_t)x;
    else
        return false;
    return type != NG_FIELD_BOOL || x == 0 || x == 1;
}

static void *edit_field(const struct lf_variations *self, const struct item *item)
{
    char *value = ng_world_edit(self->world, item->v.target, item->field.component);
    return value ? value + item->field.field->offset : NULL;
}

static const void *read_field(const struct lf_variations *self, const struct item *item)
{
    const char *value = ng_world_get(self->world, item->v.target, item->field.component);
    return value ? value + item->field.field->offset : NULL;
}

static const float *choice(const struct ng_variation *v, uint32_t i)
{
    const float *const list[NG_VARIATION_CHOICE_MAX] = {v->choice_0, v->choice_1, v->choice_2,
                                                        v->choice_3, v->choice_4, v->choice_5};
    return list[i];
}

// ---- checking --------------------------------------------------------------------------------------------

static ng_result check_box(const struct lf_variations *self, const struct item *item, const float *min,
                           const float *max, int channels, const char *what)
{
    for (int i = 0; i < channels; i++)
        if (!(min[i] <= max[i]) || !isfinite(max[i] - min[i]))
            return REFUSE(self, item, NG_ERROR_FORMAT,
                          "the %s is empty: channel %d goes from %g to %g; min has to be at most max", what,
                          i, (double)min[i], (double)max[i]);
    return NG_OK;
}

static ng_result check_value(const struct lf_variations *self, const struct item *item, const float *channels)
{
    char why[NG_REASON_SIZE] = "it wants whole numbers";
    union value value;
    double numbers[4] = {0};
    for (int i = 0; i < channels_of(item->field.field->type); i++)
        numbers[i] = (double)channels[i];
    if (!store(item->field.field->type, numbers, &value) || !ng_field_check(item->field.field, &value, why))
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s does not take these values: %s", item->v.field, why);
    return NG_OK;
}

static ng_result check_range(const struct lf_variations *self, const struct item *item)
{
    const struct ng_variation *v = &item->v;
    enum ng_field_type type = item->field.field->type;
    NG_TRY(check_box(self, item, v->min, v->max, channels_of(type), "range"));
    if (v->kind != NG_VARIATION_RANGE && !is_real(type))
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s is no real number; use \"range\" or \"choices\"",
                      v->field);
    for (int i = 0; v->kind == NG_VARIATION_LOG_RANGE && i < channels_of(type); i++)
        if (!(v->min[i] > 0))
            return REFUSE(self, item, NG_ERROR_FORMAT, "a log_range has to begin above 0, not at %g",
                          (double)v->min[i]);
    if (v->kind == NG_VARIATION_OFFSET)
        return NG_OK; // what comes out depends on the present value: checked when it is applied
    NG_TRY(check_value(self, item, v->min));
    return check_value(self, item, v->max);
}

static ng_result check_choices(const struct lf_variations *self, const struct item *item)
{
    if (item->v.choice_count < 1 || item->v.choice_count > NG_VARIATION_CHOICE_MAX)
        return REFUSE(self, item, NG_ERROR_FORMAT, "it has no choices; choice_count goes from 1 to %d",
                      NG_VARIATION_CHOICE_MAX);
    for (uint32_t i = 0; i < item->v.choice_count; i++)
        NG_TRY(check_value(self, item, choice(&item->v, i)));
    return NG_OK;
}

static ng_result check_target(const struct lf_variations *self, const struct item *item,
                              ng_component component)
{
    if (!ng_entity_alive(self->world, item->v.target))
        return REFUSE(self, item, NG_ERROR_NOT_FOUND, "its target is %s",
                      ng_entity_is_null(item->v.target) ? "not set" : "gone");
    if (!ng_world_has(self->world, item->v.target, component))
        return REFUSE(self, item, NG_ERROR_NOT_FOUND, "\"%s\" has no component %s",
                      name_of(self, item->v.target), ng_world_component(self->world, component)->name);
    return NG_OK;
}

// Finds "component.field" without a word, since what is said names the variation.
static bool find_field(const struct ng_world *world, const char *path, struct ng_field_ref *out)
{
    char component[NG_TEXT_SIZE];
    const char *dot = strchr(path, '.');
    if (!dot)
        return false;
    snprintf(component, sizeof component, "%.*s", (int)(dot - path), path);
    if (!ng_world_find_component(world, component, &out->component))
        return false;
    out->field = ng_component_field(ng_world_component(world, out->component), dot + 1);
    return out->field;
}

static ng_result check_field(const struct lf_variations *self, struct item *item)
{
    if (!find_field(self->world, item->v.field, &item->field))
        return REFUSE(self, item, NG_ERROR_NOT_FOUND, "its field \"%s\" is unknown; see %s", item->v.field,
                      "lightformer info components");
    NG_TRY(check_target(self, item, item->field.component));
    enum ng_field_type type = item->field.field->type;
    if (ng_world_component(self->world, item->field.component)->flags & NG_COMPONENT_DERIVED)
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s is computed every frame and cannot vary",
                      item->v.field);
    if (item->v.kind == NG_VARIATION_TURN) {
        if (type != NG_FIELD_QUAT)
            return REFUSE(self, item, NG_ERROR_FORMAT, "only rotations can turn, and %s is none",
                          item->v.field);
        return check_box(self, item, item->v.min, item->v.max, 3, "range");
    }
    if (channels_of(type) == 0)
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s is a %s, which cannot vary", item->v.field,
                      ng_field_type_name(type));
    if (item->v.kind == NG_VARIATION_CHOICES)
        return check_choices(self, item);
    if (type == NG_FIELD_QUAT)
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s is a rotation; use \"turn\" or \"choices\"",
                      item->v.field);
    return check_range(self, item);
}

// Whether an entity leaves its children where they are.
static bool moves_children(const struct lf_variations *self, ng_entity e)
{
    static const struct ng_transform identity = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    const struct ng_transform *t = ng_world_get(self->world, e, NG_TRANSFORM);
    return t && (!glm_vec3_eqv((float *)t->translation, (float *)identity.translation) ||
                 !glm_vec4_eqv((float *)t->rotation, (float *)identity.rotation) ||
                 !glm_vec3_eqv((float *)t->scale, (float *)identity.scale));
}

static ng_result check_camera(const struct lf_variations *self, const struct item *item)
{
    NG_TRY(check_target(self, item, NG_CAMERA));
    NG_TRY(check_target(self, item, NG_TRANSFORM));
    for (ng_entity e = ng_world_parent(self->world, item->v.target); !ng_entity_is_null(e);
         e = ng_world_parent(self->world, e))
        if (moves_children(self, e))
            return REFUSE(self, item, NG_ERROR_FORMAT,
                          "camera \"%s\" hangs on \"%s\", which has a transform; take it off",
                          name_of(self, item->v.target), name_of(self, e));
    for (int i = 0; i < 3; i++)
        for (int end = 0; end < 2; end++) {
            float x = (end ? item->v.max : item->v.min)[i];
            if (!(fabsf(x) <= NG_PLACEMENT_MAX))
                return REFUSE(self, item, NG_ERROR_FORMAT,
                              "the box of eyes reaches to %g, and %g is the most", (double)x,
                              (double)NG_PLACEMENT_MAX);
        }
    NG_TRY(check_box(self, item, item->v.min, item->v.max, 3, "box of eyes"));
    return check_box(self, item, item->v.look_min, item->v.look_max, 3, "box to look at");
}

static ng_result check(const struct lf_variations *self, size_t index)
{
    struct item *item = &self->items.items[index];
    if (item->v.kind == NG_VARIATION_TIME)
        NG_TRY(check_box(self, item, item->v.min, item->v.max, 1, "range"));
    else if (item->v.kind == NG_VARIATION_CAMERA)
        NG_TRY(check_camera(self, item));
    else
        NG_TRY(check_field(self, item));
    return NG_OK;
}

// What an item varies: the time, or a field of an entity (of a camera: null).
static int by_aim(const void *a, const void *b)
{
    const struct item *x = *(const struct item *const *)a, *y = *(const struct item *const *)b;
    bool x_time = x->v.kind == NG_VARIATION_TIME, y_time = y->v.kind == NG_VARIATION_TIME;
    if (x_time || y_time)
        return (x_time < y_time) - (x_time > y_time);
    if (!ng_entity_same(x->v.target, y->v.target))
        return x->v.target.id < y->v.target.id ? -1 : 1;
    uintptr_t x_field = (uintptr_t)x->field.field, y_field = (uintptr_t)y->field.field;
    return (x_field > y_field) - (x_field < y_field);
}

static int by_aim_and_place(const void *a, const void *b)
{
    const struct item *x = *(const struct item *const *)a, *y = *(const struct item *const *)b;
    int order = by_aim(a, b);
    return order ? order : (x > y) - (x < y);
}

static ng_result check_distinct(const struct lf_variations *self)
{
    size_t count = self->items.count;
    const struct item **sorted = malloc((count + 1) * sizeof(const struct item *));
    if (!sorted)
        return ng_out_of_memory("a scene's variations");
    for (size_t i = 0; i < count; i++)
        sorted[i] = &self->items.items[i];
    qsort(sorted, count, sizeof *sorted, by_aim_and_place);
    ng_result result = NG_OK;
    for (size_t i = 1; i < count && result == NG_OK; i++)
        if (by_aim(&sorted[i - 1], &sorted[i]) == 0)
            result = REFUSE(self, sorted[i], NG_ERROR_FORMAT, "\"%s\" varies the same already",
                            name_of(self, sorted[i - 1]->entity));
    free(sorted);
    return result;
}

// ---- finding ---------------------------------------------------------------------------------------------

static int by_entity(const void *a, const void *b)
{
    uint32_t x = ng_entity_index(((const struct item *)a)->entity),
             y = ng_entity_index(((const struct item *)b)->entity);
    return (x > y) - (x < y);
}

static ng_result collect(struct lf_variations *self)
{
    struct ng_query_desc desc = {.terms = {NG_READ(NG_VARIATION)}, .term_count = 1};
    struct ng_query *query;
    bool room = true;
    NG_TRY(ng_query_create(self->world, &desc, &query));
    ng_query_each (it, query) {
        const struct ng_variation *v = it.columns[0];
        for (uint32_t i = 0; room && i < it.count; i++)
            room = ng_array_push(&self->items, (struct item){.entity = it.entities[i], .v = v[i]});
    }
    ng_query_destroy(&query);
    if (!room)
        return ng_out_of_memory("a scene's variations");
    if (self->items.count)
        qsort(self->items.items, self->items.count, sizeof *self->items.items, by_entity);
    return NG_OK;
}

ng_result lf_variations_create(struct ng_world *world, struct lf_variations **out)
{
    *out = NULL;
    struct lf_variations *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("a scene's variations");
    self->world = world;
    ng_result result = collect(self);
    for (size_t i = 0; result == NG_OK && i < self->items.count; i++)
        result = check(self, i);
    if (result == NG_OK)
        result = check_distinct(self);
    if (result != NG_OK)
        lf_variations_destroy(&self);
    *out = self;
    return result;
}

void lf_variations_destroy(struct lf_variations **variations)
{
    struct lf_variations *self = *variations;
    *variations = NULL;
    if (!self)
        return;
    ng_array_finish(&self->items);
    free(self);
}

uint32_t lf_variations_count(const struct lf_variations *v)
{
    return (uint32_t)v->items.count;
}

// ---- drawing ---------------------------------------------------------------------------------------------

static double draw(struct ng_rng *rng, double min, double max)
{
    return min + (max - min) * (double)ng_rng_float(rng);
}

// Three axes after one another, as a quaternion x y z w.
static void turn(struct ng_rng *rng, const struct ng_variation *v, const float start[4], double out[4])
{
    static const int order[3] = {1, 0, 2};
    for (int i = 0; i < 4; i++)
        out[i] = (double)start[i];
    for (int k = 0; k < 3; k++) {
        int axis = order[k], a = (axis + 1) % 3, b = (axis + 2) % 3;
        double angle = draw(rng, (double)v->min[axis], (double)v->max[axis]);
        double s = sin(angle / 2), c = cos(angle / 2), q[4] = {out[0], out[1], out[2], out[3]};
        out[axis] = q[axis] * c + q[3] * s;
        out[a] = q[a] * c + q[b] * s;
        out[b] = q[b] * c - q[a] * s;
        out[3] = q[3] * c - q[axis] * s;
    }
    double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3]);
    for (int i = 0; i < 4; i++)
        out[i] /= length;
}

static void draw_value(struct ng_rng *rng, const struct item *item, const void *present, double out[4])
{
    const struct ng_variation *v = &item->v;
    enum ng_field_type type = item->field.field->type;
    int channels = channels_of(type);
    double shared = (double)ng_rng_float(rng);
    uint32_t chosen = ng_rng_below(rng, v->choice_count ? v->choice_count : 1);
    if (v->kind == NG_VARIATION_TURN) {
        turn(rng, v, present, out);
        return;
    }
    for (int i = 0; i < channels; i++) {
        double min = (double)v->min[i], max = (double)v->max[i];
        switch ((enum ng_variation_kind)v->kind) {
        case NG_VARIATION_LOG_RANGE:
            out[i] = exp((1 - shared) * log(min) + shared * log(max));
            out[i] = fmin(fmax(out[i], min), max);
            break;
        case NG_VARIATION_OFFSET:
            out[i] = (double)((const float *)present)[i] + draw(rng, min, max);
            break;
        case NG_VARIATION_CHOICES:
            out[i] = (double)choice(v, chosen)[i];
            break;
        default:
            out[i] = is_real(type) ? draw(rng, min, max) : fmin(floor(draw(rng, min, max + 1)), max);
        }
    }
}

static ng_result set_field(const struct lf_variations *self, struct item *item, struct ng_rng *rng)
{
    char why[NG_REASON_SIZE] = "not a whole number";
    const struct ng_field *field = item->field.field;
    const void *present = read_field(self, item);
    if (!present)
        return REFUSE(self, item, NG_ERROR_NOT_FOUND, "\"%s\" is gone", item->v.field);
    double numbers[4] = {0};
    draw_value(rng, item, present, numbers);
    if (!store(field->type, numbers, &item->set) || !ng_field_check(field, &item->set, why))
        return REFUSE(self, item, NG_ERROR_FORMAT, "%s: %s", item->v.field, why);
    memcpy(edit_field(self, item), &item->set, ng_field_size(field->type));
    return NG_OK;
}

// ---- cameras ---------------------------------------------------------------------------------------------

static bool look_at(const float eye[3], const float at[3], struct ng_transform *t)
{
    vec3 forward, right, up;
    glm_vec3_sub((float *)at, (float *)eye, forward);
    float length = glm_vec3_norm(forward);
    if (!(length > 1e-6f) || !(fabsf(forward[1]) < 0.999f * length))
        return false; // nowhere, or along the axis that points up in the picture
    glm_vec3_scale(forward, 1 / length, forward);
    glm_vec3_crossn(forward, GLM_YUP, right);
    glm_vec3_cross(right, forward, up);
    mat4 m = GLM_MAT4_IDENTITY_INIT;
    glm_vec3_copy(right, m[0]);
    glm_vec3_copy(up, m[1]);
    glm_vec3_negate_to(forward, m[2]);
    glm_mat4_quat(m, t->rotation);
    glm_quat_normalize(t->rotation);
    glm_vec3_copy((float *)eye, t->translation);
    return true;
}

static ng_result place_camera(const struct lf_variations *self, const struct item *item, struct ng_rng *rng,
                              const struct lf_variations_apply_params *p, double time)
{
    const struct ng_variation *v = &item->v;
    for (uint32_t i = 0; i < CAMERA_TRIES; i++) {
        struct ng_transform t =
            *(const struct ng_transform *)ng_world_get(self->world, v->target, NG_TRANSFORM);
        float eye[3], at[3], forward[3];
        for (int k = 0; k < 3; k++)
            eye[k] = (float)draw(rng, (double)v->min[k], (double)v->max[k]);
        for (int k = 0; k < 3; k++)
            at[k] = (float)draw(rng, (double)v->look_min[k], (double)v->look_max[k]);
        // Its scale says no more of a camera than whether it mirrors; -Z has to look ahead.
        bool mirrors = (t.scale[0] < 0) ^ (t.scale[1] < 0) ^ (t.scale[2] < 0);
        glm_vec3_copy((vec3){mirrors ? -1.0f : 1.0f, 1, 1}, t.scale);
        bool good = look_at(eye, at, &t);
        glm_quat_rotatev(t.rotation, (vec3){0, 0, -1}, forward);
        if (good && p->judge)
            NG_TRY(p->judge(p->user, time, i, eye, forward, &good));
        if (good)
            return ng_world_set(self->world, v->target, NG_TRANSFORM, &t);
    }
    return REFUSE(self, item, NG_ERROR_NOT_FOUND,
                  "no place for camera \"%s\" in %d tries with seed %" PRIu64
                  ": its boxes lie inside of things or see nothing",
                  name_of(self, v->target), CAMERA_TRIES, p->seed);
}

// ---- a sample --------------------------------------------------------------------------------------------

static struct ng_rng stream(const struct lf_variations_apply_params *p, size_t item)
{
    return ng_rng_make(p->seed, item);
}

static ng_result set_fields(struct lf_variations *self, const struct lf_variations_apply_params *p,
                            double *time)
{
    for (size_t i = 0; i < self->items.count; i++) {
        struct item *item = &self->items.items[i];
        struct ng_rng rng = stream(p, i);
        if (item->v.kind == NG_VARIATION_TIME)
            *time = draw(&rng, (double)item->v.min[0], (double)item->v.max[0]);
        else if (item->v.kind != NG_VARIATION_CAMERA)
            NG_TRY(set_field(self, item, &rng));
    }
    return NG_OK;
}

// Runs the systems. What varies must still be as it was set.
static ng_result run_systems(const struct lf_variations *self, double time)
{
    NG_TRY(ng_world_run(self->world, time));
    for (size_t i = 0; i < self->items.count; i++) {
        const struct item *item = &self->items.items[i];
        const struct ng_field *field = item->field.field;
        if (field && memcmp(read_field(self, item), &item->set, ng_field_size(field->type)) != 0)
            return REFUSE(self, item, NG_ERROR_FORMAT,
                          "%s of \"%s\" is animated, so it cannot vary; vary the time or a parent",
                          item->v.field, name_of(self, item->v.target));
    }
    return NG_OK;
}

static ng_result apply(struct lf_variations *self, const struct lf_variations_apply_params *p, double *time)
{
    NG_TRY(set_fields(self, p, time));
    NG_TRY(run_systems(self, *time));
    for (size_t i = 0; i < self->items.count; i++) {
        const struct item *item = &self->items.items[i];
        struct ng_rng rng = stream(p, i);
        if (item->v.kind == NG_VARIATION_CAMERA)
            NG_TRY(place_camera(self, item, &rng, p, *time));
    }
    return ng_world_run(self->world, *time);
}

ng_result lf_variations_apply(struct lf_variations *self, const struct lf_variations_apply_params *p,
                              double *time)
{
    char label[NG_TEXT_SIZE];
    double at = p->time;
    snprintf(label, sizeof label, "variation %" PRIu64, p->seed);
    NG_TRY(ng_world_begin(self->world, label));
    ng_result result = apply(self, p, &at);
    if (result == NG_OK)
        result = ng_world_commit(self->world);
    if (result != NG_OK && ng_world_in_transaction(self->world))
        result = ng_world_cancel(self->world) == NG_OK ? result : NG_ERROR_MEMORY;
    if (result == NG_OK && time)
        *time = at;
    return result;
}
