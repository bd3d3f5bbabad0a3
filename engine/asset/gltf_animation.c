// Animations into clips: the standard's channels drive fields of the transform, those of NG_scene any float
// field. Both end in the same channel of a clip, an entity with a component and an offset into it.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"
#include "components/animation.h"
#include "components/components.h"
#include "components/transform.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct source {
    const char *where; // "animation 0, channel 3"
    const struct gltf_animation *animation;
    int sampler;
    ng_entity target;
    ng_component component;
    const struct ng_field *field;
};

static ng_result read_interpolation(struct gltf_loader *l, const char *where, const char *name,
                                    struct ng_channel *c)
{
    static const char *const names[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    c->interpolation = NG_INTERPOLATION_LINEAR;
    for (uint32_t i = 0; i < NG_COUNT(names); i++)
        if (strcmp(name, names[i]) == 0) {
            c->interpolation = (enum ng_interpolation)i;
            return NG_OK;
        }
    return ng_gltf_fault(&l->faults, "LINEAR is used", "%s: there is no interpolation \"%.40s\"", where,
                         name);
}

// A key's value (tangents may be anything finite) is moved to one that the field may hold; quaternions are
// normalised.
static ng_result check_keys(struct gltf_loader *l, const struct source *s, struct ng_channel *c)
{
    uint32_t parts = c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1;
    for (uint32_t i = 0; i < c->key_count; i++) {
        float *v = c->values + ((size_t)i * parts + parts / 2) * c->width;
        char why[NG_REASON_SIZE];
        if (ng_field_check(s->field, v, why))
            continue;
        if (!ng_field_clamp(s->field, v))
            return ng_gltf_error(l, "%s: key %u of %s: %s", s->where, i, s->field->name, why);
        ng_gltf_warn(l, &l->warned_keys, "%s: key %u of %s: %s; it is moved there", s->where, i,
                     s->field->name, why);
    }
    return NG_OK;
}

static ng_result read_keys(struct gltf_loader *l, const struct source *s, const struct gltf_keys *keys,
                           struct ng_channel *c)
{
    uint32_t parts = c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1;
    uint32_t count = 0, components = 1;
    const struct gltf_want times = {"animation times", GLTF_FLOATS | GLTF_ANY_NUMBER, 1u << 1, 0, false};
    NG_TRY(ng_gltf_read(l, keys->input, &times, &c->times, &c->key_count));
    if (keys->output >= 0 && (uint32_t)keys->output < l->doc->accessor_count)
        components = l->doc->accessors[keys->output].components;
    const struct gltf_want values = {"animation values", GLTF_QUANTIZED | GLTF_ANY_NUMBER,
                                     1u << 1 | (s->field ? 1u << c->width : 0), 0, false};
    NG_TRY(ng_gltf_read(l, keys->output, &values, &c->values, &count));
    uint64_t there = (uint64_t)count * components, key_size = (uint64_t)parts * c->width;
    if (there != c->key_count * key_size) {
        NG_TRY(ng_gltf_fault(&l->faults, "those that have both are played",
                             "%s: accessor %d: %u elements do not fit %u keys of %s", s->where, keys->output,
                             count, c->key_count, s->field ? s->field->name : "weights"));
        c->key_count = (uint32_t)(there / key_size < c->key_count ? there / key_size : c->key_count);
    }
    NG_TRY(ng_gltf_repair_keys(l, s->where, c));
    return s->field ? check_keys(l, s, c) : NG_OK;
}

static ng_result read_channel(struct gltf_loader *l, const struct source *s, struct ng_channel *c)
{
    if (s->sampler < 0 || (uint32_t)s->sampler >= s->animation->sampler_count)
        return ng_gltf_error(l, "%s: sampler %d is not one of %u", s->where, s->sampler,
                             s->animation->sampler_count);
    const struct gltf_keys *keys = &s->animation->samplers[s->sampler];
    c->target = s->target;
    c->component = s->component;
    if (s->field) { // else the width is given
        c->field_offset = s->field->offset;
        c->width = ng_field_floats(s->field->type);
        c->rotation = s->field->type == NG_FIELD_QUAT;
    }
    NG_TRY(read_interpolation(l, s->where, keys->interpolation, c));
    return read_keys(l, s, keys, c);
}

// Another channel of the clip, for which it has room.
static ng_result add_channel(struct gltf_loader *l, const struct source *s, struct ng_clip *clip)
{
    struct ng_channel c = {0};
    struct gltf_part part;
    ng_gltf_part_begin(&part, "the channel is left out");
    part.where = s->where;
    ng_result r = ng_gltf_part_end(&l->faults, &part, read_channel(l, s, &c));
    if (r != NG_OK || part.lost) {
        free(c.times);
        free(c.values);
        return r;
    }
    clip->channels[clip->channel_count++] = c;
    if (c.key_count)
        clip->duration = fmaxf(clip->duration, c.times[c.key_count - 1]);
    return NG_OK;
}

static ng_result find_target(const struct gltf_loader *l, const char *where, int node, ng_entity *out)
{
    if (node < 0 || (uint32_t)node >= l->doc->node_count)
        return ng_gltf_error(l, "%s: node %d is not one of %u", where, node, l->doc->node_count);
    *out = l->nodes[node];
    return NG_OK;
}

// Weights of morph targets: as one wide channel, then as the fields that they drive.
static ng_result weight_channels(struct gltf_loader *l, const struct source *s, int node,
                                 struct ng_clip *clip)
{
    struct ng_channel all = {.width = ng_gltf_weight_count(l, node)};
    if (ng_gltf_weight_channels(l, node) == 0)
        return NG_OK;
    ng_result r = read_channel(l, s, &all);
    if (r == NG_OK)
        r = ng_gltf_split_weights(l, node, &all, clip);
    if (r == NG_OK)
        clip->duration = fmaxf(clip->duration, all.times[all.key_count - 1]);
    free(all.times);
    free(all.values);
    return r;
}

// A channel without a node is ignored (glTF 2.0, 5.2.1), unless an extension says what it drives.
static ng_result standard_channel(struct gltf_loader *l, const char *where, const struct gltf_animation *a,
                                  const struct gltf_channel *channel, struct ng_clip *clip)
{
    struct source s = {where, a, channel->sampler, {0}, NG_TRANSFORM, NULL};
    if (channel->node == -1)
        return NG_OK;
    NG_TRY(find_target(l, where, channel->node, &s.target));
    if (strcmp(channel->path, "weights") == 0)
        return weight_channels(l, &s, channel->node, clip);
    s.field = ng_component_field(&ng_transform_component, channel->path);
    if (!s.field)
        return ng_gltf_error(l, "%s: there is no path \"%.40s\"", where, channel->path);
    return ng_entity_is_null(s.target) ? NG_OK : add_channel(l, &s, clip); // null: a node of another scene
}

static ng_result standard_channels(struct gltf_loader *l, uint32_t index, const struct gltf_animation *a,
                                   struct ng_clip *clip)
{
    for (uint32_t i = 0; i < a->channel_count; i++) {
        struct gltf_part part;
        char where[64];
        snprintf(where, sizeof where, "animation %u, channel %u", index, i);
        ng_gltf_part_begin(&part, "the channel is left out");
        part.where = where;
        NG_TRY(ng_gltf_part_end(&l->faults, &part, standard_channel(l, where, a, &a->channels[i], clip)));
    }
    return NG_OK;
}

static ng_result text_member(const struct gltf_loader *l, const struct gltf_value *v, const char *where,
                             const char *key, const char **out)
{
    const struct gltf_value *member = ng_gltf_member(v, key);
    if (!member || member->kind != GLTF_STRING)
        return ng_gltf_error(l, "%s: \"%s\" is missing or not a text", where, key);
    *out = member->string;
    return NG_OK;
}

static ng_result find_owner(const struct gltf_loader *l, const struct gltf_value *v, const char *where,
                            ng_entity *out)
{
    int node, material;
    NG_TRY(ng_gltf_index_member(l, v, where, "node", -1, &node));
    NG_TRY(ng_gltf_index_member(l, v, where, "material", -1, &material));
    if (material < 0)
        return find_target(l, where, node, out);
    if (node >= 0 || (uint32_t)material >= l->doc->material_count)
        return ng_gltf_error(l, "%s: needs a node, or one of the %u materials", where,
                             l->doc->material_count);
    *out = l->materials[material];
    return NG_OK;
}

static ng_result find_field(const struct gltf_loader *l, const struct gltf_value *v, struct source *s)
{
    const char *component = NULL, *field = NULL;
    NG_TRY(text_member(l, v, s->where, "component", &component));
    NG_TRY(text_member(l, v, s->where, "field", &field));
    if (!ng_world_find_component(l->world, component, &s->component))
        return ng_gltf_error(l, "%s: there is no component \"%.64s\"", s->where, component);
    s->field = ng_component_field(ng_world_component(l->world, s->component), field);
    if (!s->field)
        return ng_gltf_error(l, "%s: %s has no field \"%.64s\"", s->where, component, field);
    if (ng_field_floats(s->field->type) == 0)
        return ng_gltf_error(l, "%s: %s.%s is not made of floats, it cannot be animated", s->where, component,
                             field);
    if (!ng_entity_is_null(s->target) && !ng_world_has(l->world, s->target, s->component))
        return ng_gltf_error(l, "%s: its target has no %s", s->where, component);
    return NG_OK;
}

static ng_result extension_channel(struct gltf_loader *l, const char *where, const struct gltf_animation *a,
                                   const struct gltf_value *v, struct ng_clip *clip)
{
    struct source s = {where, a, -1, {0}, 0, NULL};
    NG_TRY(ng_gltf_index_member(l, v, where, "sampler", -1, &s.sampler));
    NG_TRY(find_owner(l, v, where, &s.target));
    NG_TRY(find_field(l, v, &s));
    return ng_entity_is_null(s.target) ? NG_OK : add_channel(l, &s, clip);
}

static ng_result extension_channels(struct gltf_loader *l, uint32_t index, const struct gltf_animation *a,
                                    const struct gltf_value *channels, struct ng_clip *clip)
{
    for (uint32_t i = 0; i < channels->count; i++) {
        struct gltf_part part;
        char where[64];
        snprintf(where, sizeof where, "animation %u, NG_scene channel %u", index, i);
        ng_gltf_part_begin(&part, "the channel is left out");
        part.where = where;
        NG_TRY(
            ng_gltf_part_end(&l->faults, &part, extension_channel(l, where, a, &channels->items[i], clip)));
    }
    return NG_OK;
}

static ng_result make_clip(struct gltf_loader *l, uint32_t index, const struct gltf_animation *a,
                           struct ng_clip *clip)
{
    const struct gltf_value *extra = ng_gltf_member(a->extension, "channels");
    if (extra && extra->kind != GLTF_ARRAY) {
        NG_TRY(ng_gltf_fault(&l->faults, "it is ignored", "animation %u: NG_scene: channels is not an array",
                             index));
        extra = NULL;
    }
    size_t count = (size_t)a->channel_count + (extra ? extra->count : 0);
    for (uint32_t i = 0; i < a->channel_count; i++)
        count += strcmp(a->channels[i].path, "weights") ? 0 : ng_gltf_weight_channels(l, a->channels[i].node);
    NG_TRY(ng_gltf_budget(l, count * sizeof *clip->channels, "an animation"));
    clip->channels = calloc(count + 1, sizeof *clip->channels);
    if (!clip->channels)
        return ng_out_of_memory(l->path);
    NG_TRY(standard_channels(l, index, a, clip));
    return extra ? extension_channels(l, index, a, extra, clip) : NG_OK;
}

static void clip_finish(struct ng_clip *clip)
{
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        free(clip->channels[i].times);
        free(clip->channels[i].values);
    }
    free(clip->channels);
}

static ng_result add_animation(struct gltf_loader *l, uint32_t index, ng_entity group)
{
    const struct gltf_animation *a = &l->doc->animations[index];
    char where[32];
    snprintf(where, sizeof where, "animation %u", index);
    struct ng_clip clip = {0};
    ng_result r = make_clip(l, index, a, &clip);
    if (r == NG_OK && !ng_array_reserve(&l->added, l->added.count + 1))
        r = ng_out_of_memory(l->path);
    if (r != NG_OK) {
        clip_finish(&clip);
        return r;
    }
    l->out.duration = fmaxf(l->out.duration, clip.duration);
    struct ng_animation animation;
    memcpy(&animation, ng_animation_component.defaults, sizeof animation);
    NG_TRY(ng_assets_take_clip(l->assets, a->name[0] ? a->name : where, &clip, &animation.clip));
    ng_array_push(&l->added, animation.clip);
    ng_entity e;
    NG_TRY(ng_gltf_entity(l, group, a->name, "animation", index, &e));
    l->animations[index] = e;
    NG_TRY(ng_gltf_add(l, e, where, NG_ANIMATION, &animation));
    const struct gltf_value *components = ng_gltf_member(a->extension, "components");
    struct ng_clip_player player = {e, ng_assets_clip(l->assets, animation.clip),
                                    ng_gltf_member(components, ng_animation_component.name) != NULL};
    if (!ng_array_push(&l->clips, player))
        return ng_out_of_memory(l->path);
    return ng_gltf_components(l, e, where, a->extension, "channels");
}

ng_result ng_gltf_animations(struct gltf_loader *l)
{
    uint32_t count = l->doc->animation_count;
    if (count == 0)
        return ng_clips_play(l->world, NULL, 0, l->limits.clip);
    ng_entity group;
    NG_TRY(ng_gltf_entity(l, l->out.root, "animations", "group", 0, &group));
    for (uint32_t i = 0; i < count; i++)
        NG_TRY(add_animation(l, i, group));
    l->out.clip_count = count;
    return ng_clips_play(l->world, l->clips.items, count, l->limits.clip);
}
