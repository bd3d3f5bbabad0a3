// A cage as OpenSubdiv can take it. Its buffers have room for as many faces as edges around a vertex, which
// holds where every edge has at most two faces, of opposite directions, and the faces around a vertex are
// one fan. What is not so is divided there, as at a boundary; C++ only.
#ifndef NG_ASSET_MANIFOLD_INTERNAL_H
#define NG_ASSET_MANIFOLD_INTERNAL_H

#include <cstdint>
#include <vector>

struct ng_cage;

struct ng_manifold {
    std::vector<uint32_t> indices; // [index_count]: the cage's vertices, and copies of them after those
    std::vector<uint32_t> source;  // [vertex_count]: the cage's vertex of each
    std::vector<uint32_t> crease_edges, corners;
    std::vector<float> crease_sharpness, corner_sharpness;
    uint32_t divided_edges, first_edge[2]; // the cage's

    // The cage must have passed ng_cage_check's first part: its counts, indices and sharpness.
    explicit ng_manifold(const ng_cage *cage);
};

#endif
