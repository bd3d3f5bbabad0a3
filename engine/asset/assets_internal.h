// The store from inside: assets.c adds, removes and finds, edits.c changes what is there.
#ifndef NG_ASSET_ASSETS_INTERNAL_H
#define NG_ASSET_ASSETS_INTERNAL_H

#include "asset/content_internal.h"
#include "asset/geometry.h"
#include "base/array.h"
#include "base/pool.h"

struct ng_content_change;

struct ng_asset_record {
    enum ng_asset_kind kind;
    char *name;
    size_t place; // in the order of adding
    union ng_content content;
    struct ng_asset_revision revision;
    // Of the transaction that can restore the content already, and the change that does; null: it was taken
    // in that transaction.
    uint64_t saved;
    struct ng_content_change *change;
};

struct ng_assets {
    struct ng_pool pool;
    NG_ARRAY(struct ng_asset_record *) records; // by slot of the pool; null: free, or held by a transaction
    NG_ARRAY(uint32_t) order;                   // ids; there is always room for those that are held
    size_t held;                                // records that transactions hold
    size_t memory;
    struct ng_asset_revision latest;
    struct ng_world *world; // whose transactions record changes, or null
    struct ng_geometry_scratch scratch;
    // The store itself and each change that a transaction holds: either may be the last to go.
    size_t references;
    bool closed; // the store was destroyed
};

// Null if the id is stale.
struct ng_asset_record *ng_asset_find(const struct ng_assets *a, ng_asset id);
// A number that nothing had before.
uint64_t ng_assets_number(struct ng_assets *a);
void ng_asset_set_revision(struct ng_asset_record *r, struct ng_asset_revision revision);
// The number of the open transaction; 0: changes are not recorded.
uint64_t ng_assets_transaction(const struct ng_assets *a);
void ng_assets_release(struct ng_assets *a); // a reference

#endif
