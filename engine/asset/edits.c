// Edits: content that changes under its id. Old content is never written again once a transaction has it, so
// that a revision stays the name of bytes at their addresses: what is edited is a copy, the original is held.
#include "asset/assets.h"
#include "asset/assets_internal.h"
#include "asset/image.h"
#include "base/log.h"
#include "scene/history.h"

#include <math.h>
#include <stdlib.h>

// ---- old content -----------------------------------------------------------------------------------------
// What a transaction holds of an asset that it edited.
struct ng_content_change {
    struct ng_assets *assets;
    ng_asset id;
    enum ng_asset_kind kind;
    bool points;    // points alone, not the whole content
    bool with_rest; // there were none at rest before
    union ng_content held;
    struct ng_asset_revision revision; // of what is held
};

static void exchange_content(void *change, bool forward)
{
    struct ng_content_change *c = change;
    struct ng_asset_record *r = ng_asset_find(c->assets, c->id);
    NG_UNUSED(forward);
    // An edit that was not recorded may have taken it away, or given it another topology, however alike.
    if (!r || (c->points && r->revision.topology != c->revision.topology))
        return;
    struct ng_assets *a = c->assets;
    a->memory -= ng_content_size(r->kind, &r->content);
    if (c->points) {
        ng_content_swap(c->kind, NG_PART_POINTS, &r->content, &c->held);
        if (c->with_rest)
            ng_content_swap(c->kind, NG_PART_REST, &r->content, &c->held);
    } else {
        union ng_content now = r->content;
        r->content = c->held;
        c->held = now;
    }
    struct ng_asset_revision was = r->revision;
    ng_asset_set_revision(r, c->revision);
    c->revision = was;
    a->memory += ng_content_size(r->kind, &r->content);
    (void)ng_assets_number(a);
    if (was.topology != r->revision.topology)
        a->latest.topology = a->latest.content;
}

static void finish_content(void *change, bool done)
{
    struct ng_content_change *c = change;
    NG_UNUSED(done);
    ng_content_finish(c->kind, &c->held);
    ng_assets_release(c->assets);
    free(c);
}

static uint64_t content_bytes(const void *change)
{
    const struct ng_content_change *c = change;
    return sizeof *c + ng_content_size(c->kind, &c->held);
}

// A change in the open transaction that holds nothing yet.
static ng_result record_change(struct ng_assets *a, ng_asset id, struct ng_asset_record *r,
                               struct ng_content_change **out)
{
    static const struct ng_change_type type = {exchange_content, finish_content, content_bytes};
    struct ng_content_change *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c)
        return ng_out_of_memory(r->name);
    *c = (struct ng_content_change){.assets = a, .id = id, .kind = r->kind, .revision = r->revision};
    ng_result result = ng_world_record(a->world, &type, c);
    if (result != NG_OK) {
        free(c);
        return result;
    }
    a->references++;
    r->saved = ng_assets_transaction(a);
    r->change = *out = c;
    return NG_OK;
}

// Whether undo can give the content back, or need not.
static bool is_saved(const struct ng_assets *a, const struct ng_asset_record *r)
{
    uint64_t transaction = ng_assets_transaction(a);
    return !transaction || r->saved == transaction;
}

static struct ng_asset_record *find_kind(const struct ng_assets *a, ng_asset id, enum ng_asset_kind kind)
{
    struct ng_asset_record *r = ng_asset_find(a, id);
    return r && r->kind == kind ? r : NULL;
}

static void bump(struct ng_assets *a, struct ng_asset_record *r, bool topology)
{
    struct ng_asset_revision revision = r->revision;
    revision.content = ng_assets_number(a);
    if (topology)
        revision.topology = a->latest.topology = revision.content;
    ng_asset_set_revision(r, revision);
}

// ---- in place --------------------------------------------------------------------------------------------
static bool has_rest(const struct ng_asset_record *r)
{
    return r->kind == NG_ASSET_CAGE ? r->content.cage.rest_positions : r->content.geometry.rest_positions;
}

// Copies of the points take the place of the originals, which the open transaction gets.
static ng_result save_points(struct ng_assets *a, ng_asset id, struct ng_asset_record *r)
{
    union ng_content original;
    struct ng_content_change *change;
    if (!ng_content_fork_points(r->kind, &r->content, &original))
        return ng_out_of_memory(r->name);
    ng_result result = record_change(a, id, r, &change);
    if (result != NG_OK) {
        ng_content_swap(r->kind, NG_PART_POINTS, &r->content, &original);
        ng_content_finish(r->kind, &original);
        return result;
    }
    change->held = original;
    change->points = true;
    change->with_rest = !has_rest(r);
    bump(a, r, false);
    return NG_OK;
}

float *ng_assets_edit_points(struct ng_assets *a, ng_asset id)
{
    struct ng_asset_record *r = ng_asset_find(a, id);
    if (!r || (r->kind != NG_ASSET_GEOMETRY && r->kind != NG_ASSET_CAGE))
        return NULL;
    if (!is_saved(a, r) && save_points(a, id, r) != NG_OK)
        return NULL;
    if (!has_rest(r)) {
        size_t before = ng_content_size(r->kind, &r->content);
        if (!ng_content_make_rest(r->kind, &r->content)) {
            (void)ng_out_of_memory(r->name);
            return NULL;
        }
        a->memory += ng_content_size(r->kind, &r->content) - before;
    }
    return r->kind == NG_ASSET_CAGE ? r->content.cage.positions : r->content.geometry.positions;
}

// The same of a whole content.
static struct ng_asset_record *edit_whole(struct ng_assets *a, ng_asset id, enum ng_asset_kind kind)
{
    struct ng_asset_record *r = find_kind(a, id, kind);
    if (!r || is_saved(a, r))
        return r;
    union ng_content copy;
    struct ng_content_change *change;
    if (!ng_content_copy(kind, &r->content, &copy)) {
        (void)ng_out_of_memory(r->name);
        return NULL;
    }
    if (record_change(a, id, r, &change) != NG_OK) {
        ng_content_finish(kind, &copy);
        return NULL;
    }
    change->held = r->content;
    r->content = copy;
    bump(a, r, false);
    return r;
}

void *ng_assets_edit_texels(struct ng_assets *a, ng_asset id)
{
    struct ng_asset_record *r = edit_whole(a, id, NG_ASSET_IMAGE);
    return r ? r->content.image.pixels : NULL;
}

struct ng_clip *ng_assets_edit_clip(struct ng_assets *a, ng_asset id)
{
    struct ng_asset_record *r = edit_whole(a, id, NG_ASSET_CLIP);
    return r ? &r->content.clip : NULL;
}

static void find_duration(struct ng_clip *clip)
{
    clip->duration = 0;
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        const struct ng_channel *c = &clip->channels[i];
        if (c->key_count)
            clip->duration = fmaxf(clip->duration, c->times[c->key_count - 1]);
    }
}

ng_result ng_assets_changed(struct ng_assets *a, ng_asset id)
{
    struct ng_asset_record *r = ng_asset_find(a, id);
    NG_REQUIRE(r, "asset %u was edited, and is no more", id.id);
    if (r->kind == NG_ASSET_GEOMETRY)
        NG_TRY(ng_geometry_follow_points(&r->content.geometry, &a->scratch));
    else if (r->kind == NG_ASSET_IMAGE)
        ng_image_update_mips(&r->content.image);
    else if (r->kind == NG_ASSET_CLIP)
        find_duration(&r->content.clip);
    bump(a, r, false);
    return NG_OK;
}

// ---- replacing -------------------------------------------------------------------------------------------
// The old content, for the open transaction's change: as it was before that transaction.
static void hold_old_content(struct ng_asset_record *r, struct ng_content_change *change)
{
    if (change->points) {
        exchange_content(change, false);
        ng_content_finish(r->kind, &change->held); // the points that were edited since
        change->points = change->with_rest = false;
    }
    change->held = r->content;
    change->revision = r->revision;
}

static ng_result replace(struct ng_assets *a, ng_asset id, enum ng_asset_kind kind, union ng_content *content)
{
    struct ng_asset_record *r = find_kind(a, id, kind);
    struct ng_content_change *change = NULL;
    ng_result result = r ? NG_OK : NG_ERROR_NOT_FOUND;
    if (!r)
        ng_log_error("asset %u cannot be replaced: it is no more, or of another kind", id.id);
    else if (!is_saved(a, r))
        result = record_change(a, id, r, &change);
    else if (ng_assets_transaction(a) && r->change && r->change->points)
        change = r->change;
    if (result != NG_OK) {
        ng_content_finish(kind, content);
        return result;
    }
    if (change)
        hold_old_content(r, change);
    a->memory += ng_content_size(kind, content) - ng_content_size(kind, &r->content);
    if (!change)
        ng_content_finish(kind, &r->content);
    r->content = *content;
    bump(a, r, true);
    return NG_OK;
}

ng_result ng_assets_replace_geometry(struct ng_assets *a, ng_asset id, struct ng_geometry *g)
{
    union ng_content c = {.geometry = *g};
    *g = (struct ng_geometry){0};
    return replace(a, id, NG_ASSET_GEOMETRY, &c);
}

ng_result ng_assets_replace_cage(struct ng_assets *a, ng_asset id, struct ng_cage *cage)
{
    union ng_content c = {.cage = *cage};
    *cage = (struct ng_cage){0};
    return replace(a, id, NG_ASSET_CAGE, &c);
}

ng_result ng_assets_replace_image(struct ng_assets *a, ng_asset id, struct ng_image *image)
{
    union ng_content c = {.image = *image};
    *image = (struct ng_image){0};
    return replace(a, id, NG_ASSET_IMAGE, &c);
}

ng_result ng_assets_replace_clip(struct ng_assets *a, ng_asset id, struct ng_clip *clip)
{
    union ng_content c = {.clip = *clip};
    *clip = (struct ng_clip){0};
    return replace(a, id, NG_ASSET_CLIP, &c);
}
