// Fields are numbered by sorting every channel of every clip; then one pass over the clips, in their order,
// gives each field to the first that drives it.
#include "anim/clips.h"

#include "base/log.h"
#include "components/animation.h"
#include "components/components.h"
#include "components/name.h"
#include "scene/world.h"

#include <stdlib.h>
#include <string.h>

// A channel: the field that it drives, and where it stands in the order of all channels.
struct driven {
    uint64_t target, field;
    size_t index;
};

static int compare_driven(const void *a, const void *b)
{
    const struct driven *x = a, *y = b;
    if (x->target != y->target)
        return x->target < y->target ? -1 : 1;
    return (x->field > y->field) - (x->field < y->field);
}

static size_t count_channels(const struct ng_clip_player *players, uint32_t count)
{
    size_t channels = 0;
    for (uint32_t i = 0; i < count; i++)
        channels += players[i].clip ? players[i].clip->channel_count : 0;
    return channels;
}

static bool set_playing(struct ng_world *world, ng_entity e, bool playing)
{
    const struct ng_animation *now = ng_world_get(world, e, NG_ANIMATION);
    if (!now || now->playing == playing)
        return true;
    struct ng_animation *animation = ng_world_edit(world, e, NG_ANIMATION);
    if (animation)
        animation->playing = playing;
    return animation;
}

// [channels]: the number of the field that each channel drives, in the order of clips; null: no memory.
static size_t *number_fields(const struct ng_clip_player *players, uint32_t count, size_t channels)
{
    struct driven *driven = malloc((channels + 1) * sizeof *driven);
    size_t *fields = malloc((channels + 1) * sizeof *fields), n = 0;
    if (!driven || !fields) {
        free(driven);
        free(fields);
        return NULL;
    }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; players[i].clip && k < players[i].clip->channel_count; k++, n++) {
            const struct ng_channel *c = &players[i].clip->channels[k];
            driven[n] = (struct driven){c->target.id, (uint64_t)c->component << 32 | c->field_offset, n};
        }
    qsort(driven, n, sizeof *driven, compare_driven);
    size_t field = 0;
    for (size_t i = 0; i < n; i++) {
        field += i && compare_driven(&driven[i - 1], &driven[i]) != 0;
        fields[driven[i].index] = field;
    }
    free(driven);
    return fields;
}

static bool any_taken(const bool *taken, const size_t *fields, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (taken[fields[i]])
            return true;
    return false;
}

static ng_result play_first(struct ng_world *world, const struct ng_clip_player *players, uint32_t count)
{
    size_t channels = count_channels(players, count), at = 0;
    size_t *fields = number_fields(players, count, channels);
    bool *taken = calloc(channels + 1, sizeof *taken), done = fields && taken;
    for (uint32_t i = 0; done && i < count; i++) {
        size_t own = players[i].clip ? players[i].clip->channel_count : 0;
        bool plays = !any_taken(taken, fields + at, own);
        for (size_t k = 0; k < own && plays && !players[i].blends; k++)
            taken[fields[at + k]] = true;
        at += own;
        if (!players[i].blends)
            done = set_playing(world, players[i].entity, plays);
    }
    free(fields);
    free(taken);
    return done ? NG_OK : ng_out_of_memory("the playing clips");
}

static bool is_named(const struct ng_world *world, ng_entity e, const char *name)
{
    const struct ng_name *own = ng_world_get(world, e, NG_NAME);
    return own && strcmp(own->text, name) == 0;
}

ng_result ng_clips_play(struct ng_world *world, const struct ng_clip_player *players, uint32_t count,
                        const char *choice)
{
    if (!choice)
        return play_first(world, players, count);
    bool all = strcmp(choice, "all") == 0, none = strcmp(choice, "none") == 0;
    uint32_t found = 0;
    while (!all && !none && found < count && !is_named(world, players[found].entity, choice))
        found++;
    if (!all && !none && found == count) {
        ng_log_error("no clip is named '%s'; `lightformer info SCENE` lists the clips", choice);
        return NG_ERROR_NOT_FOUND;
    }
    for (uint32_t i = 0; i < count; i++)
        if (!set_playing(world, players[i].entity, all || (!none && i == found)))
            return NG_ERROR_MEMORY;
    return NG_OK;
}

// ---- what fields held ------------------------------------------------------------------------------------

struct ng_rest_value {
    ng_entity target;
    ng_component component;
    uint32_t offset, size; // bytes
    float value[4];
};

ng_result ng_clips_rest_take(const struct ng_world *world, const struct ng_clip_player *players,
                             uint32_t count, struct ng_clips_rest *out)
{
    *out = (struct ng_clips_rest){.values = calloc(count_channels(players, count) + 1, sizeof *out->values)};
    if (!out->values)
        return ng_out_of_memory("the playing clips");
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; players[i].clip && k < players[i].clip->channel_count; k++) {
            const struct ng_channel *c = &players[i].clip->channels[k];
            struct ng_rest_value v = {
                c->target, c->component, c->field_offset, c->width * (uint32_t)sizeof(float), {0}};
            const char *now = ng_world_get(world, c->target, c->component);
            if (!now || v.size > sizeof v.value)
                continue;
            memcpy(v.value, now + v.offset, v.size);
            out->values[out->count++] = v;
        }
    return NG_OK;
}

void ng_clips_rest_put(const struct ng_clips_rest *rest, struct ng_world *world)
{
    for (uint32_t i = 0; i < rest->count; i++) {
        const struct ng_rest_value *v = &rest->values[i];
        const char *now = ng_world_get(world, v->target, v->component);
        if (!now || memcmp(now + v->offset, v->value, v->size) == 0)
            continue;
        char *value = ng_world_write(world, v->target, v->component);
        memcpy(value + v->offset, v->value, v->size);
    }
}

void ng_clips_rest_finish(struct ng_clips_rest *rest)
{
    free(rest->values);
    *rest = (struct ng_clips_rest){0};
}
