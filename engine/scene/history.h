// Transactions, undo and redo.
//
// Between begin and commit every change made by hand is recorded: create, destroy (with all below), add,
// remove, edit, set, set_parent. One transaction is one entry of the undo list, however many changes it has:
// a drag begins when the button goes down and commits when it comes up. Changes outside a transaction are not
// recorded; changes to derived components (NG_COMPONENT_DERIVED), ng_world_write and query loops never are.
//
// Undo gives destroyed entities back under the same id. It is itself a change: ticks move forward, events
// tell it. Where something unrecorded has meanwhile destroyed what an entry speaks of, that part is passed
// over.
//
// Others take part with changes of their own (struct ng_change_type): an asset store does.
//
// Calls in the wrong state (nested begin, undo while open or while a query is iterated) are errors (USAGE).
#ifndef NG_SCENE_HISTORY_H
#define NG_SCENE_HISTORY_H

#include "base/extern_c.h"
#include "scene/world.h"

NG_EXTERN_C_BEGIN

// `label` is copied, cut to NG_TEXT_SIZE: what the menu shows after "Undo".
NG_NODISCARD ng_result ng_world_begin(struct ng_world *world, const char *label);
// Ends the transaction: a new undo entry, unless nothing was recorded. What had been undone can no longer be
// redone. Out of memory: it stays open, and can be cancelled.
NG_NODISCARD ng_result ng_world_commit(struct ng_world *world);
// Ends the transaction and takes back what it recorded.
NG_NODISCARD ng_result ng_world_cancel(struct ng_world *world);
bool ng_world_in_transaction(const struct ng_world *world);
// Number of the open transaction, never given before; 0: none is open.
uint64_t ng_world_transaction(const struct ng_world *world);

// Takes the latest entry back, or does it again. NOT_FOUND, silently, where there is none.
NG_NODISCARD ng_result ng_world_undo(struct ng_world *world);
NG_NODISCARD ng_result ng_world_redo(struct ng_world *world);
// What undo or redo would act on; null if nothing.
const char *ng_world_undo_label(const struct ng_world *world);
const char *ng_world_redo_label(const struct ng_world *world);
// Forgets all entries, as after loading a scene. Not while a transaction is open.
void ng_world_clear_history(struct ng_world *world);
// Bytes that entries may hold in all, from the next commit on; 0: 256 MiB. The oldest go first, the newest
// stays whatever it holds.
void ng_world_limit_history(struct ng_world *world, uint64_t bytes);
uint64_t ng_world_history_bytes(const struct ng_world *world); // held now

// A change to something that is no entity. It holds what its owner does not have at the moment: done, the old
// content; undone, the new one.
struct ng_change_type {
    // Takes the change back, or makes it again (`forward`). Cannot fail: what it needs is there since the
    // change was made. Not a change itself: nothing is recorded.
    void (*exchange)(void *change, bool forward);
    // Forgets a change; `done`: it was in force. Also when the world is destroyed.
    void (*finish)(void *change, bool done);
    uint64_t (*bytes)(const void *change); // held at the moment
};
// Adds a change that was just made to the open transaction, which owns it from then on. `type` must be
// static. On failure (out of memory, no transaction) it stays the caller's.
NG_NODISCARD ng_result ng_world_record(struct ng_world *world, const struct ng_change_type *type,
                                       void *change);

NG_EXTERN_C_END

#endif
