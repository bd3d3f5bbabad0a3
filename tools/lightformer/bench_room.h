// A room with seven lamps, built in code: what one of them costs that is dragged.
#ifndef LIGHTFORMER_BENCH_ROOM_H
#define LIGHTFORMER_BENCH_ROOM_H

#include "base/result.h"
#include "scene/entity.h"

#define BENCH_ROOM_LAMPS 7u

struct ng_assets;
struct ng_world;

// Adds it, camera included, to a world without another scene. `lamps` are rectangles in the ceiling.
NG_NODISCARD ng_result bench_room_make(struct ng_world *world, struct ng_assets *assets,
                                       ng_entity lamps[BENCH_ROOM_LAMPS]);

#endif
