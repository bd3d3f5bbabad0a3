// The plan: every channel of every playing animation, sorted by the field that it drives; a run of channels
// on one field is a slot. A frame samples and blends slot by slot on the jobs, each into its own value, then
// writes, in order and on one thread, the values that differ from the world's.
//
// The plan is made again when the list of playing animations (their entities, clips and the clips' revisions)
// changes.
#include "anim/animate.h"

#include "anim/sample.h"
#include "base/array.h"
#include "base/hash.h"
#include "base/jobs.h"
#include "base/log.h"
#include "components/components.h"
#include "scene/query.h"
#include "scene/system.h"
#include "scene/world.h"

#include <stdlib.h>
#include <string.h>

#define GRAIN 64u // slots a job chunk

// An animation that plays this frame.
struct player {
    ng_entity entity;
    struct ng_animation animation;
    const struct ng_clip *clip;
};

struct link {
    const struct ng_channel *channel;
    uint32_t player, entity; // index of the player and of its entity
};

struct slot {
    uint32_t first, count;        // links
    const struct ng_field *field; // null: the component has none there
    float value[4];
    bool valid;
};

struct ng_animator {
    struct ng_world *world; // of the query
    struct ng_query *query;
    uint64_t plan; // hash of the players it was made for; 0: none
    NG_ARRAY(struct player) players;
    NG_ARRAY(struct link) links;
    NG_ARRAY(struct slot) slots;
    double time;
};

ng_result ng_animator_create(struct ng_animator **out)
{
    *out = calloc(1, sizeof **out);
    return *out ? NG_OK : ng_out_of_memory("an animator");
}

void ng_animator_destroy(struct ng_animator **animator)
{
    struct ng_animator *a = *animator;
    *animator = NULL;
    if (!a)
        return;
    ng_query_destroy(&a->query);
    ng_array_finish(&a->players);
    ng_array_finish(&a->links);
    ng_array_finish(&a->slots);
    free(a);
}

// Lists what plays, in the order of entity ids: query order depends on the world's history, and sums of
// floats on their order.
static ng_result find_players(struct ng_animator *a, const struct ng_animate_params *p)
{
    a->players.count = 0;
    ng_query_each (it, a->query) {
        const struct ng_animation *animations = it.columns[0];
        for (uint32_t i = 0; i < it.count; i++) {
            const struct ng_animation *animation = &animations[i];
            if (!animation->playing || !(animation->weight > 0))
                continue;
            const struct ng_clip *clip = p->lookup(p->user, animation->clip);
            if (!clip)
                continue;
            if (!ng_array_push(&a->players, (struct player){it.entities[i], *animation, clip})) {
                ng_query_stop(&it);
                return ng_out_of_memory("the playing clips");
            }
        }
    }
    return NG_OK;
}

static uint64_t plan_of(const struct ng_animator *a)
{
    uint64_t hash = 1;
    for (size_t i = 0; i < a->players.count; i++) {
        const struct player *player = &a->players.items[i];
        hash = ng_hash_combine(hash, player->entity.id);
        hash = ng_hash_combine(hash, player->animation.clip.id);
        hash = ng_hash_combine(hash, player->clip->revision);
        hash = ng_hash_combine(hash, (uint64_t)(uintptr_t)player->clip);
    }
    return hash;
}

static int compare_fields(const struct ng_channel *x, const struct ng_channel *y)
{
    if (x->target.id != y->target.id)
        return x->target.id < y->target.id ? -1 : 1;
    if (x->component != y->component)
        return x->component < y->component ? -1 : 1;
    return (x->field_offset > y->field_offset) - (x->field_offset < y->field_offset);
}

// On one field in the order of entities: players are in the order of the query, which depends on the world's
// history, and a sum of floats depends on its order.
static int compare_links(const void *a, const void *b)
{
    const struct link *x = a, *y = b;
    int order = compare_fields(x->channel, y->channel);
    return order ? order : (x->entity > y->entity) - (x->entity < y->entity);
}

static const struct ng_field *field_of(const struct ng_world *world, const struct ng_channel *c)
{
    const struct ng_component_desc *desc = ng_world_component(world, c->component);
    for (uint32_t i = 0; desc && i < desc->field_count; i++) {
        const struct ng_field *field = &desc->fields[i];
        if (field->offset == c->field_offset && ng_field_size(field->type) == c->width * sizeof(float))
            return field;
    }
    return NULL;
}

static ng_result make_plan(struct ng_animator *a)
{
    a->plan = 0;
    a->links.count = a->slots.count = 0;
    for (uint32_t i = 0; i < a->players.count; i++) {
        const struct player *player = &a->players.items[i];
        for (uint32_t k = 0; k < player->clip->channel_count; k++) {
            struct link link = {&player->clip->channels[k], i, ng_entity_index(player->entity)};
            if (!ng_array_push(&a->links, link))
                return ng_out_of_memory("the playing clips");
        }
    }
    if (a->links.count > 1)
        qsort(a->links.items, a->links.count, sizeof a->links.items[0], compare_links);
    for (uint32_t i = 0; i < a->links.count; i++) {
        const struct ng_channel *channel = a->links.items[i].channel;
        if (i && !compare_fields(a->links.items[i - 1].channel, channel)) {
            a->slots.items[a->slots.count - 1].count++;
            continue;
        }
        struct slot slot = {.first = i, .count = 1, .field = field_of(a->world, channel)};
        if (!ng_array_push(&a->slots, slot))
            return ng_out_of_memory("the playing clips");
    }
    a->plan = plan_of(a);
    return NG_OK;
}

static void sample_slots(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct ng_animator *a = user;
    for (uint32_t i = begin; i < end; i++) {
        struct slot *slot = &a->slots.items[i];
        struct ng_blend blend = {0};
        const struct ng_channel *first = a->links.items[slot->first].channel;
        for (uint32_t k = slot->first; k < slot->first + slot->count; k++) {
            const struct link *link = &a->links.items[k];
            const struct player *player = &a->players.items[link->player];
            if (!link->channel->key_count || link->channel->width != first->width)
                continue;
            float value[4], t = ng_clip_time(&player->animation, player->clip->duration, a->time);
            ng_channel_sample(link->channel, t, value);
            ng_blend_add(&blend, value, first->width, first->rotation, player->animation.weight);
        }
        // Splines overshoot: what comes out has to be a value of the field all the same.
        slot->valid = ng_blend_result(&blend, first->width, first->rotation, slot->value) && slot->field &&
                      ng_field_clamp(slot->field, slot->value);
    }
}

static void write_slots(const struct ng_animator *a, struct ng_world *world)
{
    for (size_t i = 0; i < a->slots.count; i++) {
        const struct slot *slot = &a->slots.items[i];
        const struct ng_channel *c = a->links.items[slot->first].channel;
        size_t size = c->width * sizeof(float);
        const unsigned char *now = ng_world_get(world, c->target, c->component);
        if (!slot->valid || !now || !memcmp(now + c->field_offset, slot->value, size))
            continue;
        unsigned char *value = ng_world_write(world, c->target, c->component);
        memcpy(value + c->field_offset, slot->value, size);
    }
}

ng_result ng_animate(struct ng_animator *a, const struct ng_animate_params *p)
{
    NG_REQUIRE(p->world && p->lookup, "ng_animate needs a world and a clip lookup");
    NG_REQUIRE(!a->world || a->world == p->world, "an animator belongs to one world");
    if (!a->query) {
        const struct ng_query_desc desc = {.terms = {{.component = NG_ANIMATION}}, .term_count = 1};
        NG_TRY(ng_query_create(p->world, &desc, &a->query));
        a->world = p->world;
    }
    NG_TRY(find_players(a, p));
    if (a->plan != plan_of(a))
        NG_TRY(make_plan(a));
    a->time = p->time;
    ng_jobs_for(p->jobs, (uint32_t)a->slots.count, GRAIN, sample_slots, a);
    write_slots(a, p->world);
    return NG_OK;
}

// ---- as a system -----------------------------------------------------------------------------------------
struct animation_system {
    struct ng_animator *animator;
    struct ng_animate_params params;
};

static ng_result run_system(void *user, struct ng_world *world, double time)
{
    struct animation_system *system = user;
    NG_UNUSED(world);
    system->params.time = time;
    return ng_animate(system->animator, &system->params);
}

static void finish_system(void *user)
{
    struct animation_system *system = user;
    ng_animator_destroy(&system->animator);
    free(system);
}

ng_result ng_animation_system_add(const struct ng_animate_params *p)
{
    NG_REQUIRE(p->world && p->lookup, "ng_animation_system_add needs a world and a clip lookup");
    struct animation_system *system = calloc(1, sizeof *system);
    if (!system)
        return ng_out_of_memory("the playing clips");
    system->params = *p;
    ng_result r = ng_animator_create(&system->animator);
    if (r == NG_OK)
        r = ng_world_add_system(p->world, &(struct ng_system_desc){.name = "animation",
                                                                   .phase = NG_PHASE_ANIMATE,
                                                                   .run = run_system,
                                                                   .finish = finish_system,
                                                                   .user = system});
    if (r != NG_OK)
        finish_system(system);
    return r;
}
