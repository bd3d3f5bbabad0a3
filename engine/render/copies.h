// Copies of a mesh in the very same place. Files pile them up by the thousand, and each would be drawn over
// the one before in every view, and met by every ray there. Those that no picture shows are found here, for
// whoever draws or traces a snapshot.
#ifndef NG_RENDER_COPIES_H
#define NG_RENDER_COPIES_H

#include "base/array.h"
#include "base/result.h"
#include "render/index_map.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

// Of copies that blend so many are seen, the last of them.
#define NG_MOST_BLENDED_COPIES 64u

// Zero is empty; memory is kept from one frame to the next.
struct ng_copies {
    NG_ARRAY(bool) hidden;    // of each instance of the snapshot: a later one covers all of it
    NG_ARRAY(uint32_t) over;  // of each instance: later ones that are alike
    struct ng_index_map last; // of those that are alike, the last one so far
};

// Sets `hidden`. The surfaces of lights are never hidden: each of them is absent where its own light is
// looked at.
NG_NODISCARD ng_result ng_copies_find(struct ng_copies *copies, const struct ng_snapshot *snapshot);
void ng_copies_finish(struct ng_copies *copies);

NG_EXTERN_C_END

#endif
