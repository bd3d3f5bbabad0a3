// One pool of ids for all kinds: an id's record says what kind it is. Records are on the heap one by one, so
// that pointers into them stay valid while the store grows, and so that a transaction can hold one whole.
#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/assets.h"
#include "asset/assets_internal.h"
#include "base/log.h"
#include "base/serial.h"
#include "scene/history.h"

#include <stdlib.h>
#include <string.h>

ng_result ng_assets_create(struct ng_assets **out)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ng_out_of_memory("a set of assets");
    (*out)->references = 1;
    (*out)->latest.content = (*out)->latest.topology = ng_serial_range();
    return NG_OK;
}

static void record_destroy(struct ng_asset_record *r)
{
    ng_content_finish(r->kind, &r->content);
    free(r->name);
    free(r);
}

void ng_assets_release(struct ng_assets *a)
{
    if (--a->references == 0)
        free(a);
}

void ng_assets_destroy(struct ng_assets **assets)
{
    struct ng_assets *a = *assets;
    if (!a)
        return;
    for (size_t i = 0; i < a->order.count; i++)
        record_destroy(a->records.items[ng_pool_slot(a->order.items[i])]);
    ng_array_finish(&a->records);
    ng_array_finish(&a->order);
    ng_pool_finish(&a->pool);
    ng_geometry_scratch_finish(&a->scratch);
    a->closed = true;
    ng_assets_release(a);
    *assets = NULL;
}

void ng_assets_set_history(struct ng_assets *a, struct ng_world *world)
{
    a->world = world;
}

uint64_t ng_assets_transaction(const struct ng_assets *a)
{
    return a->world ? ng_world_transaction(a->world) : 0;
}

struct ng_asset_record *ng_asset_find(const struct ng_assets *a, ng_asset id)
{
    return !a->closed && ng_pool_has(&a->pool, id.id) ? a->records.items[ng_pool_slot(id.id)] : NULL;
}

// ---- revisions -------------------------------------------------------------------------------------------
uint64_t ng_assets_number(struct ng_assets *a)
{
    return ++a->latest.content;
}

void ng_asset_set_revision(struct ng_asset_record *r, struct ng_asset_revision revision)
{
    r->revision = revision;
    if (r->kind == NG_ASSET_CLIP)
        r->content.clip.revision = revision.content;
}

struct ng_asset_revision ng_assets_revision(const struct ng_assets *a, ng_asset id)
{
    const struct ng_asset_record *r = ng_asset_find(a, id);
    return r ? r->revision : (struct ng_asset_revision){0};
}

struct ng_asset_revision ng_assets_latest(const struct ng_assets *a)
{
    return a->latest;
}

// ---- coming and going ------------------------------------------------------------------------------------
// Puts a record where it belongs in the order. There is room for it.
static void enter(struct ng_assets *a, ng_asset id, struct ng_asset_record *r)
{
    size_t place = r->place < a->order.count ? r->place : a->order.count;
    memmove(a->order.items + place + 1, a->order.items + place,
            (a->order.count++ - place) * sizeof a->order.items[0]);
    a->order.items[place] = id.id;
    a->records.items[ng_pool_slot(id.id)] = r;
    for (size_t i = place; i < a->order.count; i++)
        a->records.items[ng_pool_slot(a->order.items[i])]->place = i;
    a->memory += ng_content_size(r->kind, &r->content);
    a->latest.topology = ng_assets_number(a);
}

static struct ng_asset_record *leave(struct ng_assets *a, ng_asset id)
{
    struct ng_asset_record *r = ng_asset_find(a, id);
    for (size_t i = r->place + 1; i < a->order.count; i++) {
        a->order.items[i - 1] = a->order.items[i];
        a->records.items[ng_pool_slot(a->order.items[i])]->place = i - 1;
    }
    a->order.count--;
    a->records.items[ng_pool_slot(id.id)] = NULL;
    a->memory -= ng_content_size(r->kind, &r->content);
    a->latest.topology = ng_assets_number(a);
    return r;
}

// An asset that was taken or removed in a transaction. While it is not in the store its id stays its own.
struct presence_change {
    struct ng_assets *assets;
    ng_asset id;
    struct ng_asset_record *held; // null: it is in the store, or gone for good
};

static void exchange_presence(void *change, bool forward)
{
    struct presence_change *c = change;
    struct ng_assets *a = c->assets;
    NG_UNUSED(forward);
    if (a->closed)
        return;
    if (c->held) {
        enter(a, c->id, c->held);
        a->held--;
        c->held = NULL;
    } else if (ng_asset_find(a, c->id)) {
        c->held = leave(a, c->id);
        a->held++;
    }
}

static void finish_presence(void *change, bool done)
{
    struct presence_change *c = change;
    NG_UNUSED(done);
    if (c->held) {
        record_destroy(c->held);
        c->assets->held--;
        if (!c->assets->closed)
            ng_pool_release(&c->assets->pool, c->id.id);
    }
    ng_assets_release(c->assets);
    free(c);
}

static uint64_t presence_bytes(const void *change)
{
    const struct ng_asset_record *held = ((const struct presence_change *)change)->held;
    return sizeof(struct presence_change) + (held ? ng_content_size(held->kind, &held->content) : 0);
}

// Has the open transaction, if there is one, record that an asset came or is about to go; `*out` is the
// change, or null.
static ng_result record_presence(struct ng_assets *a, ng_asset id, struct presence_change **out)
{
    static const struct ng_change_type type = {exchange_presence, finish_presence, presence_bytes};
    *out = NULL;
    if (!ng_assets_transaction(a))
        return NG_OK;
    struct presence_change *c = calloc(1, sizeof *c);
    if (!c)
        return ng_out_of_memory("a transaction");
    *c = (struct presence_change){.assets = a, .id = id};
    ng_result r = ng_world_record(a->world, &type, c);
    if (r != NG_OK) {
        free(c);
        return r;
    }
    a->references++;
    *out = c;
    return NG_OK;
}

// Gives a record an id and a place in the order; on failure nothing has changed.
static bool insert(struct ng_assets *a, struct ng_asset_record *r, ng_asset *out)
{
    if (!ng_array_reserve(&a->order, a->order.count + a->held + 1))
        return false;
    ng_asset id = {ng_pool_acquire(&a->pool)};
    if (!id.id)
        return false;
    uint32_t slot = ng_pool_slot(id.id);
    struct presence_change *change;
    if ((slot >= a->records.count && !ng_array_resize(&a->records, (size_t)slot + 1)) ||
        record_presence(a, id, &change) != NG_OK) {
        ng_pool_release(&a->pool, id.id);
        return false;
    }
    r->place = a->order.count;
    r->saved = ng_assets_transaction(a);
    enter(a, id, r);
    ng_asset_set_revision(r, (struct ng_asset_revision){a->latest.content, a->latest.content});
    *out = id;
    return true;
}

static ng_result take(struct ng_assets *a, enum ng_asset_kind kind, const char *name,
                      union ng_content *content, ng_asset *out)
{
    *out = (ng_asset){0};
    struct ng_asset_record *r = calloc(1, sizeof *r);
    char *copy = strdup(name ? name : "");
    if (r && copy) {
        *r = (struct ng_asset_record){.kind = kind, .name = copy, .content = *content};
        if (insert(a, r, out))
            return NG_OK;
    }
    ng_log_error("%s: out of memory for another asset (%zu are loaded)", name ? name : "asset",
                 a->order.count);
    ng_content_finish(kind, content);
    free(copy);
    free(r);
    return NG_ERROR_MEMORY;
}

ng_result ng_assets_take_geometry(struct ng_assets *a, const char *name, struct ng_geometry *g, ng_asset *out)
{
    union ng_content c = {.geometry = *g};
    *g = (struct ng_geometry){0};
    return take(a, NG_ASSET_GEOMETRY, name, &c, out);
}

ng_result ng_assets_take_cage(struct ng_assets *a, const char *name, struct ng_cage *cage, ng_asset *out)
{
    union ng_content c = {.cage = *cage};
    *cage = (struct ng_cage){0};
    return take(a, NG_ASSET_CAGE, name, &c, out);
}

ng_result ng_assets_take_image(struct ng_assets *a, const char *name, struct ng_image *image, ng_asset *out)
{
    union ng_content c = {.image = *image};
    *image = (struct ng_image){0};
    return take(a, NG_ASSET_IMAGE, name, &c, out);
}

ng_result ng_assets_take_skeleton(struct ng_assets *a, const char *name, struct ng_skeleton *s, ng_asset *out)
{
    union ng_content c = {.skeleton = *s};
    *s = (struct ng_skeleton){0};
    return take(a, NG_ASSET_SKELETON, name, &c, out);
}

ng_result ng_assets_take_clip(struct ng_assets *a, const char *name, struct ng_clip *clip, ng_asset *out)
{
    union ng_content c = {.clip = *clip};
    *clip = (struct ng_clip){0};
    return take(a, NG_ASSET_CLIP, name, &c, out);
}

bool ng_assets_remove(struct ng_assets *a, ng_asset id)
{
    struct presence_change *change;
    if (!ng_asset_find(a, id) || record_presence(a, id, &change) != NG_OK)
        return false;
    if (change) {
        exchange_presence(change, true);
        return true;
    }
    record_destroy(leave(a, id));
    return ng_pool_release(&a->pool, id.id);
}

// ---- finding ---------------------------------------------------------------------------------------------
static const union ng_content *get(const struct ng_assets *a, ng_asset id, enum ng_asset_kind kind)
{
    const struct ng_asset_record *r = ng_asset_find(a, id);
    return r && r->kind == kind ? &r->content : NULL;
}

const struct ng_geometry *ng_assets_geometry(const struct ng_assets *a, ng_asset id)
{
    const union ng_content *c = get(a, id, NG_ASSET_GEOMETRY);
    return c ? &c->geometry : NULL;
}

const struct ng_cage *ng_assets_cage(const struct ng_assets *a, ng_asset id)
{
    const union ng_content *c = get(a, id, NG_ASSET_CAGE);
    return c ? &c->cage : NULL;
}

const struct ng_image *ng_assets_image(const struct ng_assets *a, ng_asset id)
{
    const union ng_content *c = get(a, id, NG_ASSET_IMAGE);
    return c ? &c->image : NULL;
}

const struct ng_skeleton *ng_assets_skeleton(const struct ng_assets *a, ng_asset id)
{
    const union ng_content *c = get(a, id, NG_ASSET_SKELETON);
    return c ? &c->skeleton : NULL;
}

const struct ng_clip *ng_assets_clip(const struct ng_assets *a, ng_asset id)
{
    const union ng_content *c = get(a, id, NG_ASSET_CLIP);
    return c ? &c->clip : NULL;
}

const char *ng_assets_name(const struct ng_assets *a, ng_asset id)
{
    const struct ng_asset_record *r = ng_asset_find(a, id);
    return r ? r->name : NULL;
}

ng_asset ng_assets_next(const struct ng_assets *a, enum ng_asset_kind kind, ng_asset previous)
{
    size_t i = 0;
    if (previous.id) {
        const struct ng_asset_record *r = ng_asset_find(a, previous);
        if (!r)
            return (ng_asset){0};
        i = r->place + 1;
    }
    for (; i < a->order.count; i++)
        if (a->records.items[ng_pool_slot(a->order.items[i])]->kind == kind)
            return (ng_asset){a->order.items[i]};
    return (ng_asset){0};
}

size_t ng_assets_memory(const struct ng_assets *a)
{
    return a->memory;
}
