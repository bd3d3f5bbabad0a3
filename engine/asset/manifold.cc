// The corners of all faces are numbered through. Two corners at one vertex belong together where their faces
// lie on both sides of a good edge; each set of corners that belong together is a fan, and gets a vertex of
// its own.
//
// The surface stays closed along what is divided: a vertex there is a sharp corner of all its fans, or, on a
// line that all of them pass along, a point of the same boundary curve.
#include "asset/manifold_internal.h"

#include "asset/assets.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace
{

constexpr uint32_t none = UINT32_MAX;
constexpr float infinitely_sharp = 10.0f;

uint64_t edge_key(uint32_t a, uint32_t b)
{
    return (uint64_t)std::min(a, b) << 32 | std::max(a, b);
}

// One side of an edge: from a corner of a face to the next.
struct Side {
    uint64_t edge;
    uint32_t corner;

    bool operator<(const Side &other) const
    {
        return edge != other.edge ? edge < other.edge : corner < other.corner;
    }
};

struct Fan {
    uint32_t vertex; // of the cage
    uint32_t faces;
    uint32_t ends[2]; // edges of more or less than two good sides where it begins and ends; none: a ring
};

// What the fans of a vertex have in common.
struct Around {
    uint32_t fans;
    uint32_t ends[2]; // of the first, in ascending order
    bool touched;     // by an edge that is divided
    bool torn;        // its fans do not all pass along one line
};

class Divider
{
  public:
    Divider(const ng_cage *cage, ng_manifold *out)
        : cage_(cage), out_(out), next_(cage->index_count), parent_(cage->index_count),
          around_(cage->vertex_count)
    {
        find_sides();
        std::iota(parent_.begin(), parent_.end(), 0);
        each_edge([this](size_t begin, size_t end) { join(begin, end); });
        number_fans();
        each_edge([this](size_t begin, size_t end) { note_ends(begin, end); });
        compare_fans();
        place_creases();
        place_corners();
    }

  private:
    void find_sides()
    {
        uint32_t first = 0;
        sides_.reserve(cage_->index_count);
        for (uint32_t f = 0; f < cage_->face_count; first += cage_->face_sizes[f++])
            for (uint32_t i = 0; i < cage_->face_sizes[f]; i++) {
                uint32_t corner = first + i;
                next_[corner] = first + (i + 1) % cage_->face_sizes[f];
                sides_.push_back({edge_key(vertex(corner), vertex(next_[corner])), corner});
            }
        std::sort(sides_.begin(), sides_.end());
    }
    uint32_t vertex(uint32_t corner) const
    {
        return cage_->face_indices[corner];
    }
    template <class Fn> void each_edge(Fn fn) const
    {
        for (size_t begin = 0, end; begin < sides_.size(); begin = end) {
            for (end = begin + 1; end < sides_.size() && sides_[end].edge == sides_[begin].edge;)
                end++;
            fn(begin, end);
        }
    }
    bool is_good(size_t begin, size_t end) const
    {
        return end - begin == 2 && vertex(sides_[begin].corner) != vertex(sides_[begin + 1].corner);
    }

    uint32_t root(uint32_t corner)
    {
        while (parent_[corner] != corner)
            corner = parent_[corner] = parent_[parent_[corner]];
        return corner;
    }
    void unite(uint32_t a, uint32_t b)
    {
        a = root(a);
        b = root(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    void join(size_t begin, size_t end)
    {
        uint32_t a = sides_[begin].corner;
        if (is_good(begin, end)) {
            uint32_t b = sides_[begin + 1].corner;
            unite(a, next_[b]);
            unite(next_[a], b);
        } else if (end - begin > 1 && out_->divided_edges++ == 0) {
            out_->first_edge[0] = vertex(a);
            out_->first_edge[1] = vertex(next_[a]);
        }
    }

    // The first fan of a vertex keeps its number, so that a good cage stays as it is.
    void number_fans()
    {
        for (uint32_t v = 0; v < cage_->vertex_count; v++)
            fans_.push_back({v, 0, {none, none}});
        out_->indices.resize(cage_->index_count);
        for (uint32_t corner = 0; corner < cage_->index_count; corner++) {
            uint32_t v = vertex(corner), first = root(corner); // never after the corner itself
            if (first == corner && around_[v].fans++ == 0)
                out_->indices[corner] = v;
            else if (first == corner) {
                out_->indices[corner] = (uint32_t)fans_.size();
                fans_.push_back({v, 0, {none, none}});
            } else
                out_->indices[corner] = out_->indices[first];
            fans_[out_->indices[corner]].faces++;
        }
        for (const Fan &fan : fans_)
            out_->source.push_back(fan.vertex);
    }
    void note_end(uint32_t corner, size_t edge, bool divided)
    {
        Fan &fan = fans_[out_->indices[corner]];
        fan.ends[fan.ends[0] != none] = (uint32_t)edge;
        around_[fan.vertex].touched |= divided;
        around_[fan.vertex].torn |= !divided;
    }
    void note_ends(size_t begin, size_t end)
    {
        for (size_t i = begin; i < end && !is_good(begin, end); i++) {
            note_end(sides_[i].corner, begin, end - begin > 1);
            note_end(next_[sides_[i].corner], begin, end - begin > 1);
        }
    }
    void compare_fans()
    {
        std::vector<bool> seen(around_.size());
        for (Fan &fan : fans_) {
            Around &a = around_[fan.vertex];
            std::sort(fan.ends, fan.ends + 2);
            if (!seen[fan.vertex])
                std::copy_n(fan.ends, 2, a.ends);
            seen[fan.vertex] = true;
            a.torn |= fan.faces < 2 || fan.ends[0] == fan.ends[1] || fan.ends[0] != a.ends[0] ||
                      fan.ends[1] != a.ends[1];
        }
    }

    // Edges that are divided or a boundary are sharp already. Others keep their fans apart from each other.
    void place_creases()
    {
        std::unordered_map<uint64_t, float> creases;
        for (size_t i = 0; i < cage_->crease_count; i++) {
            const uint32_t *ends = cage_->crease_edges + i * 2;
            creases[edge_key(ends[0], ends[1])] = cage_->crease_sharpness[i];
        }
        each_edge([&](size_t begin, size_t end) {
            auto found = creases.find(sides_[begin].edge);
            if (found == creases.end() || !is_good(begin, end))
                return;
            uint32_t corner = sides_[begin].corner;
            for (uint32_t at : {corner, next_[corner]}) {
                out_->crease_edges.push_back(out_->indices[at]);
                around_[vertex(at)].torn = true;
            }
            out_->crease_sharpness.push_back(found->second);
        });
    }
    void place_corners()
    {
        std::vector<float> sharpness(cage_->vertex_count, 0.0f);
        for (uint32_t i = 0; i < cage_->corner_count; i++)
            sharpness[cage_->corners[i]] = cage_->corner_sharpness[i];
        for (uint32_t i = 0; i < fans_.size(); i++) {
            const Around &a = around_[fans_[i].vertex];
            bool sharp = a.torn && (a.touched || a.fans > 1);
            float s = sharp ? infinitely_sharp : sharpness[fans_[i].vertex];
            if (s > 0) {
                out_->corners.push_back(i);
                out_->corner_sharpness.push_back(s);
            }
        }
    }

    const ng_cage *cage_;
    ng_manifold *out_;
    std::vector<Side> sides_;      // by edge
    std::vector<uint32_t> next_;   // by corner: the next of its face
    std::vector<uint32_t> parent_; // by corner: of a union-find
    std::vector<Fan> fans_;
    std::vector<Around> around_; // by the cage's vertex
};

} // namespace

ng_manifold::ng_manifold(const ng_cage *cage) : divided_edges(0), first_edge{0, 0}
{
    Divider(cage, this);
}
