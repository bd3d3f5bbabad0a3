// A scene with another number of lights or of things in it: how cost grows with them.
#ifndef LIGHTFORMER_BENCH_SCENE_H
#define LIGHTFORMER_BENCH_SCENE_H

#include "base/result.h"
#include "scene/world.h"

#include <stdint.h>

// Makes the world have `count` lights, and writes them to `lights`: the surplus is destroyed; what is missing
// are copies of those there are, in turn, each some centimetres from the last. They stay where they are while
// the first ones move. `*kinds`: how many of them are the scene's own. A scene without lights: all are null.
NG_NODISCARD ng_result bench_scene_set_lights(struct ng_world *world, uint32_t count, ng_entity *lights,
                                              uint32_t *kinds);

// Of the `total` lights that it wrote, switches `count` on, from `first` on and round, and the others off.
NG_NODISCARD ng_result bench_scene_switch_lights(struct ng_world *world, const ng_entity *lights,
                                                 uint32_t total, uint32_t first, uint32_t count);

// Makes everything that is subdivided a flock of `copies` smaller ones (a square number) in the same place,
// of the cage alone, so that as much of the picture is covered as before. `*pieces`: how many there are then.
NG_NODISCARD ng_result bench_scene_set_copies(struct ng_world *world, uint32_t copies, uint32_t *pieces);

#endif
