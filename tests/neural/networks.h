// Networks for tests, as files.
#ifndef NG_TESTS_NEURAL_NETWORKS_H
#define NG_TESTS_NEURAL_NETWORKS_H

#include "test.h"

// What physics knows and nothing learned: unshadowed light from the clues, hard shadows from the depth of
// occluders, one bounce. Linear in the lights, exactly.
void network_write_physics(const char *path);
// A small network of every kind of operation that a family uses, with random weights: U-Nets in the encoding
// and in the gather, means over VPLs and texels, gates of heads.
void network_write_random(const char *path, uint64_t seed);
// The same with weights so large that nothing it gives is finite.
void network_write_overflowing(const char *path);
// A random one that also reads absolute positions and powers, as the paper's does.
void network_write_absolute(const char *path, uint64_t seed);

#endif
