// Clips into animations: what drives a node's transform, or the weights of its morph targets, is the
// standard's, all else NG_scene's.
#include "asset/gltf_save_internal.h"
#include "asset/gltf_unit.h"
#include "base/log.h"
#include "components/animation.h"
#include "components/components.h"
#include "components/mesh.h"
#include "components/morph.h"
#include "components/transform.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void normalize4(float *v)
{
    (void)ng_gltf_normalize_rotation(v);
}

static int add_values(struct gltf_saver *s, const struct ng_channel *c)
{
    unsigned parts = c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1;
    size_t count = (size_t)c->key_count * parts;
    float *values = malloc(count * c->width * sizeof *values + 1);
    if (!values) {
        s->w.failed = true;
        return 0;
    }
    memcpy(values, c->values, count * c->width * sizeof *values);
    for (size_t i = 0; c->rotation && i < c->key_count; i++) {
        size_t at = (i * parts + parts / 2) * c->width;
        ng_gltf_before_normalizing(normalize4, 4, c->values + at, values + at);
    }
    int index = ng_gltf_add_floats(&s->w, values, count, c->width, NG_GLTF_NO_TARGET, false);
    free(values);
    return index;
}

// Channels mostly share their times.
struct times {
    const struct ng_channel *channel;
    int accessor;
};

static int add_times(struct gltf_saver *s, const struct ng_channel *c, struct times *last)
{
    if (!last->channel || last->channel->key_count != c->key_count ||
        memcmp(last->channel->times, c->times, c->key_count * sizeof *c->times) != 0)
        *last =
            (struct times){c, ng_gltf_add_floats(&s->w, c->times, c->key_count, 1, NG_GLTF_NO_TARGET, true)};
    return last->accessor;
}

// Of the keys of a channel, with values that are in an accessor.
static int add_sampler(struct gltf_saver *s, cJSON *samplers, const struct ng_channel *c, int values,
                       struct times *last)
{
    static const char *const names[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    cJSON *sampler = ng_gltf_json_append(&s->w, samplers);
    ng_gltf_json_number(&s->w, sampler, "input", add_times(s, c, last));
    ng_gltf_json_text(&s->w, sampler, "interpolation", names[c->interpolation]);
    ng_gltf_json_number(&s->w, sampler, "output", values);
    return cJSON_GetArraySize(samplers) - 1;
}

static const struct ng_field *find_field(const struct gltf_saver *s, const struct ng_channel *c)
{
    const struct ng_component_desc *desc = ng_world_component(s->world, c->component);
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (desc->fields[i].offset == c->field_offset)
            return &desc->fields[i];
    return NULL;
}

// Whether what a channel drives is in the document.
static bool has_target(const struct gltf_saver *s, const struct ng_channel *c)
{
    const struct gltf_saved *p = ng_gltf_saved(s, c->target);
    bool part = p && p->role == GLTF_PRIMITIVE && c->component == NG_MORPH;
    return p && (p->role == GLTF_NODE || p->role == GLTF_MATERIAL || part) &&
           ng_world_has(s->world, c->target, c->component);
}

static bool have_targets(const struct gltf_saver *s, const struct ng_clip *clip)
{
    for (uint32_t i = 0; i < clip->channel_count; i++)
        if (!has_target(s, &clip->channels[i]))
            return false;
    return true;
}

// ---- weights of morph targets ----------------------------------------------------------------------------
// In the standard one channel has those of all targets of a node's mesh. Here four are a field, and each
// primitive has its own.
struct weights {
    uint32_t targets;
    const struct ng_channel *fields[NG_MORPH_TARGETS / 4];
};

static bool same_keys(const struct ng_channel *a, const struct ng_channel *b)
{
    return a->key_count == b->key_count && a->interpolation == b->interpolation &&
           memcmp(a->times, b->times, a->key_count * sizeof *a->times) == 0;
}

static const struct ng_channel *find_channel(const struct ng_clip *clip, ng_entity target, uint32_t offset)
{
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        const struct ng_channel *c = &clip->channels[i];
        if (c->component == NG_MORPH && c->field_offset == offset && ng_entity_same(c->target, target))
            return c;
    }
    return NULL;
}

// All fields of the targets that an entity's geometry has, if they have the same keys.
static bool find_weights(const struct gltf_saver *s, const struct ng_clip *clip, ng_entity e,
                         struct weights *out)
{
    const struct ng_mesh *mesh = ng_world_get(s->world, e, NG_MESH);
    const struct ng_geometry *g = mesh ? ng_assets_geometry(s->assets, mesh->geometry) : NULL;
    out->targets = g && g->target_count <= NG_MORPH_TARGETS ? g->target_count : 0;
    for (uint32_t f = 0; f * 4 < out->targets; f++) {
        out->fields[f] = find_channel(clip, e, ng_morph_component.fields[f].offset);
        if (!out->fields[f] || !same_keys(out->fields[0], out->fields[f]))
            return false;
    }
    return out->targets > 0;
}

static int add_weights(struct gltf_saver *s, const struct weights *w)
{
    const struct ng_channel *c = w->fields[0];
    size_t rows = (size_t)c->key_count * (c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1);
    float *values = malloc(rows * w->targets * sizeof *values + 1);
    if (!values) {
        s->w.failed = true;
        return 0;
    }
    for (size_t row = 0; row < rows; row++)
        for (uint32_t t = 0; t < w->targets; t++)
            values[row * w->targets + t] = w->fields[t / 4]->values[row * 4 + t % 4];
    int index = ng_gltf_add_floats(&s->w, values, rows * w->targets, 1, NG_GLTF_NO_TARGET, false);
    free(values);
    return index;
}

// The first channel of the weights of a node, of whichever of its primitives; null: the standard cannot say
// what these do.
static const struct ng_channel *first_of_node(const struct gltf_saver *s, const struct ng_clip *clip,
                                              const struct gltf_saved *p, struct weights *out)
{
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        const struct ng_channel *c = &clip->channels[i];
        const struct gltf_saved *other = c->component == NG_MORPH ? ng_gltf_saved(s, c->target) : NULL;
        if (other && other->index == p->index &&
            (other->role == GLTF_NODE || other->role == GLTF_PRIMITIVE) && has_target(s, c))
            return find_weights(s, clip, c->target, out) ? c : NULL;
    }
    return NULL;
}

// False where the standard has no place for it.
static bool add_weight_channel(struct gltf_saver *s, cJSON *animation, const struct ng_clip *clip,
                               const struct ng_channel *c, struct times *last)
{
    const struct gltf_saved *p = ng_gltf_saved(s, c->target);
    struct weights weights;
    if (c->component != NG_MORPH || !has_target(s, c) || p->role == GLTF_MATERIAL)
        return false;
    const struct ng_channel *first = first_of_node(s, clip, p, &weights);
    if (first != c) // the first says it for all
        return first != NULL;
    cJSON *channel = ng_gltf_json_append(&s->w, ng_gltf_json_list(&s->w, animation, "channels"));
    cJSON *samplers = ng_gltf_json_list(&s->w, animation, "samplers");
    cJSON *target = ng_gltf_json_object(&s->w, channel, "target");
    ng_gltf_json_number(&s->w, channel, "sampler",
                        add_sampler(s, samplers, weights.fields[0], add_weights(s, &weights), last));
    ng_gltf_json_number(&s->w, target, "node", p->index);
    ng_gltf_json_text(&s->w, target, "path", "weights");
    return true;
}

// ---- channels --------------------------------------------------------------------------------------------
static void add_channel(struct gltf_saver *s, cJSON *animation, const struct ng_channel *c,
                        struct times *last)
{
    const struct gltf_saved *p = ng_gltf_saved(s, c->target);
    const struct ng_field *f = find_field(s, c);
    if (!f || !has_target(s, c) || p->role == GLTF_PRIMITIVE) {
        if (!s->warned_channel)
            ng_log_warn("%s: channels of what is gone, or neither a node nor a material, are left out",
                        s->path);
        s->warned_channel = true;
        return;
    }
    bool standard = c->component == NG_TRANSFORM && p->role == GLTF_NODE;
    cJSON *owner = standard ? animation : ng_gltf_json_extension(&s->w, animation, "NG_scene");
    cJSON *channel = ng_gltf_json_append(&s->w, ng_gltf_json_list(&s->w, owner, "channels"));
    ng_gltf_json_number(
        &s->w, channel, "sampler",
        add_sampler(s, ng_gltf_json_list(&s->w, animation, "samplers"), c, add_values(s, c), last));
    cJSON *target = standard ? ng_gltf_json_object(&s->w, channel, "target") : channel;
    ng_gltf_json_number(&s->w, target, p->role == GLTF_NODE ? "node" : "material", p->index);
    if (!standard)
        ng_gltf_json_text(&s->w, target, "component", ng_world_component(s->world, c->component)->name);
    ng_gltf_json_text(&s->w, target, standard ? "path" : "field", f->name);
}

// The standard wants a channel of its own; one without a node drives nothing.
static void add_idle_channel(struct gltf_saver *s, cJSON *animation)
{
    static const float start[1] = {0}, nowhere[3] = {0};
    cJSON *channels = ng_gltf_json_list(&s->w, animation, "channels");
    cJSON *samplers = ng_gltf_json_list(&s->w, animation, "samplers");
    if (!channels || channels->child)
        return;
    cJSON *sampler = ng_gltf_json_append(&s->w, samplers), *channel = ng_gltf_json_append(&s->w, channels);
    ng_gltf_json_number(&s->w, sampler, "input",
                        ng_gltf_add_floats(&s->w, start, 1, 1, NG_GLTF_NO_TARGET, true));
    ng_gltf_json_number(&s->w, sampler, "output",
                        ng_gltf_add_floats(&s->w, nowhere, 1, 3, NG_GLTF_NO_TARGET, false));
    ng_gltf_json_number(&s->w, channel, "sampler", cJSON_GetArraySize(samplers) - 1);
    ng_gltf_json_text(&s->w, ng_gltf_json_object(&s->w, channel, "target"), "path", "translation");
}

static void put_clip(struct gltf_saver *s, cJSON *animation, const struct ng_clip *clip)
{
    struct times last = {0};
    ng_gltf_release_animation(s, animation);
    ng_gltf_json_remove(animation, "channels");
    ng_gltf_json_remove(animation, "samplers");
    ng_gltf_json_remove(cJSON_GetObjectItemCaseSensitive(
                            cJSON_GetObjectItemCaseSensitive(animation, "extensions"), "NG_scene"),
                        "channels");
    ng_gltf_json_list(&s->w, animation, "channels");
    for (uint32_t i = 0; i < clip->channel_count; i++)
        if (!add_weight_channel(s, animation, clip, &clip->channels[i], &last))
            add_channel(s, animation, &clip->channels[i], &last);
    add_idle_channel(s, animation);
}

void ng_gltf_save_animation(struct gltf_saver *s, const struct gltf_saved *p)
{
    cJSON *json = ng_gltf_saved_json(s, p);
    const struct ng_animation *now = ng_world_get(s->world, p->entity, NG_ANIMATION);
    const struct ng_animation *was = ng_gltf_kept_value(s->origin, s->world, p->kept, NG_ANIMATION);
    const struct ng_clip *clip = ng_assets_clip(s->assets, now->clip);
    ng_gltf_save_name(s, p, json);
    if (clip && (!was || was->clip.id != now->clip.id ||
                 !ng_gltf_kept_asset(s->origin, s->assets, now->clip) || !have_targets(s, clip)))
        put_clip(s, json, clip);
    ng_gltf_save_component(s, p, json, NG_ANIMATION, NG_GLTF_IMPLIED);
    ng_gltf_save_others(s, p, json, (uint64_t)1 << NG_ANIMATION);
}
