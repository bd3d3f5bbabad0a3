// A scene with another number of lights or of things in it: how cost grows with them.
#ifndef LIGHTFORMER_BENCH_SCENE_H
#define LIGHTFORMER_BENCH_SCENE_H

#include "base/result.h"

#include <stdint.h>

struct ng_world;

// Makes the world have so many lights: the surplus is destroyed, what is missing are copies of those there
// are, each some centimetres from the last. They stay where they are while the first ones move.
NG_NODISCARD ng_result bench_scene_set_lights(struct ng_world *world, uint32_t count);

// Switches the first `count` lights on and the others off.
NG_NODISCARD ng_result bench_scene_switch_lights(struct ng_world *world, uint32_t count);

// Makes everything that is subdivided a flock of `copies` smaller ones (a square number) in the same place,
// of the cage alone, so that as much of the picture is covered as before. `*pieces`: how many there are then.
NG_NODISCARD ng_result bench_scene_set_copies(struct ng_world *world, uint32_t copies, uint32_t *pieces);

#endif
