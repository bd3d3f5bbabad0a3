// The weights of the cage's vertices in each refined vertex are OpenSubdiv's stencils for the last level,
// combined with its masks for the limit position and the two limit tangents. Both are linear, so their
// product is one sparse row a vertex with three weights an entry.
//
// A refined vertex becomes several output vertices where its face-varying UVs differ, and where edges that
// are still sharp divide the faces around it into sectors.
#include "asset/refiner.h"

#include "asset/assets.h"
#include "asset/manifold_internal.h"
#include "base/jobs.h"
#include "base/log.h"
#include "components/subdivision.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <numeric>
#include <unordered_map>
#include <vector>

using namespace OpenSubdiv;

namespace
{

constexpr uint32_t max_corners = 1024; // of a face, and faces of a vertex: OpenSubdiv's masks grow with them
constexpr float still_sharp = 1.0f;    // an edge of this sharpness is a crease in the refined mesh

struct Weights {
    float position, u, v;
};

// Lists of varying length, one after the other.
struct Lists {
    std::vector<uint32_t> offsets, items;

    // Item i goes to list keys[i].
    void build(size_t count, const std::vector<uint32_t> &keys, const std::vector<uint32_t> &values)
    {
        offsets.assign(count + 1, 0);
        items.resize(keys.size());
        for (uint32_t key : keys)
            offsets[key + 1]++;
        std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
        std::vector<uint32_t> next(offsets.begin(), offsets.end() - 1);
        for (size_t i = 0; i < keys.size(); i++)
            items[next[keys[i]]++] = values[i];
    }
    size_t bytes() const
    {
        return (offsets.capacity() + items.capacity()) * sizeof(uint32_t);
    }
};

} // namespace

struct ng_refiner {
    Lists rows; // by refined vertex: cage vertices
    std::vector<Weights> weights;

    // By output vertex.
    std::vector<uint32_t> row, sector; // sector UINT32_MAX: the limit normal
    std::vector<float> uvs;
    Lists fans; // triangles around it

    std::vector<uint32_t> indices;
    Lists sectors; // triangles
};

namespace
{

// ---- checks -----------------------------------------------------------------------------------------------

bool fail(char *why, const char *what, uint64_t index)
{
    std::snprintf(why, NG_REASON_SIZE, "%s %llu", what, (unsigned long long)index);
    return false;
}

bool check_sizes(const ng_cage *c, char *why)
{
    uint64_t corners = 0;
    if (c->face_count == 0 || c->vertex_count == 0) {
        std::snprintf(why, NG_REASON_SIZE, "it has no faces");
        return false;
    }
    for (uint32_t f = 0; f < c->face_count; f++) {
        if (c->face_sizes[f] < 3 || c->face_sizes[f] > max_corners)
            return fail(why, "the number of corners is not in 3 to 1,024 at face", f);
        corners += c->face_sizes[f];
    }
    if (corners != c->index_count)
        std::snprintf(why, NG_REASON_SIZE, "the faces have %llu corners, but there are %u indices",
                      (unsigned long long)corners, c->index_count);
    return corners == c->index_count;
}

bool check_faces(const ng_cage *c, char *why)
{
    std::vector<uint32_t> last_face(c->vertex_count, UINT32_MAX), faces(c->vertex_count, 0);
    size_t at = 0;
    for (uint32_t f = 0; f < c->face_count; f++)
        for (uint32_t i = 0; i < c->face_sizes[f]; i++, at++) {
            uint32_t v = c->face_indices[at];
            if (v >= c->vertex_count)
                return fail(why, "a vertex is out of range at face", f);
            if (last_face[v] == f)
                return fail(why, "a vertex comes twice in face", f);
            last_face[v] = f;
            if (++faces[v] > max_corners)
                return fail(why, "more than 1,024 faces share vertex", v);
        }
    return true;
}

bool check_sharpness(float sharpness)
{
    return sharpness >= 0 && sharpness <= 10; // not so if it is NaN
}

bool check_creases(const ng_cage *c, char *why)
{
    for (size_t i = 0; i < c->crease_count; i++) {
        if (c->crease_edges[i * 2] >= c->vertex_count || c->crease_edges[i * 2 + 1] >= c->vertex_count)
            return fail(why, "a vertex is out of range at crease", i);
        if (!check_sharpness(c->crease_sharpness[i]))
            return fail(why, "the sharpness is not in 0 to 10 at crease", i);
    }
    for (size_t i = 0; i < c->corner_count; i++) {
        if (c->corners[i] >= c->vertex_count)
            return fail(why, "a vertex is out of range at corner", i);
        if (!check_sharpness(c->corner_sharpness[i]))
            return fail(why, "the sharpness is not in 0 to 10 at corner", i);
    }
    return true;
}

bool check_cage(const ng_cage *c, char *why)
{
    return check_sizes(c, why) && check_faces(c, why) && check_creases(c, why);
}

// What the rows will take: a refined vertex depends on the vertices around its cage face, two for each face
// at a corner of valence n less the shared ones.
uint64_t estimate_memory(const ng_cage *c, uint32_t level)
{
    std::vector<uint32_t> valence(c->vertex_count, 0);
    for (uint32_t i = 0; i < c->index_count; i++)
        valence[c->face_indices[i]]++;
    uint64_t total = 0, at = 0;
    uint64_t scale = level ? (uint64_t)1 << (2 * (level - 1)) : 1; // refined vertices a corner
    for (uint32_t f = 0; f < c->face_count; f++) {
        uint64_t entries = 0, n = c->face_sizes[f];
        for (uint64_t i = 0; i < n; i++)
            entries += std::max<uint64_t>(2 * (uint64_t)valence[c->face_indices[at + i]], 8) - 4;
        total += n * scale * (entries * 24 + 128);
        at += n;
    }
    return total;
}

ng_result check(const ng_cage *c, const ng_refiner_params *p, char *why)
{
    NG_REQUIRE(p->level <= NG_REFINER_MAX_LEVEL, "level %u is over %d", p->level, NG_REFINER_MAX_LEVEL);
    NG_REQUIRE(p->boundary <= NG_BOUNDARY_EDGE_AND_CORNER, "there is no boundary rule %u", p->boundary);
    if (!check_cage(c, why))
        return NG_ERROR_FORMAT;
    uint64_t limit = p->max_memory ? p->max_memory : (uint64_t)1 << 30, need = estimate_memory(c, p->level);
    if (need <= limit)
        return NG_OK;
    std::snprintf(why, NG_REASON_SIZE,
                  "level %u needs about %llu MiB, over the limit of %llu; use a lower one", p->level,
                  (unsigned long long)(need >> 20), (unsigned long long)(limit >> 20));
    return NG_ERROR_UNSUPPORTED;
}

// ---- topology --------------------------------------------------------------------------------------------

// Distinct UVs, so that corners with the same UV are joined.
struct Uvs {
    std::vector<float> values; // [count][2]
    std::vector<int> indices;  // by corner

    void build(const ng_cage *c)
    {
        std::unordered_map<uint64_t, int> seen;
        for (uint32_t i = 0; i < c->index_count; i++) {
            uint64_t key;
            std::memcpy(&key, c->face_uvs + (size_t)i * 2, sizeof key);
            auto found = seen.emplace(key, (int)seen.size());
            if (found.second)
                values.insert(values.end(), c->face_uvs + (size_t)i * 2, c->face_uvs + (size_t)i * 2 + 2);
            indices.push_back(found.first->second);
        }
    }
};

void on_error(Far::ErrorType, const char *message)
{
    ng_log_debug("OpenSubdiv: %s", message);
}

std::unique_ptr<Far::TopologyRefiner> make_topology(const ng_cage *c, const ng_manifold &m,
                                                    const ng_refiner_params *p, const Uvs &uvs)
{
    Far::SetErrorCallback(on_error);
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(p->boundary == NG_BOUNDARY_EDGE_ONLY
                                            ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                            : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
    Far::TopologyDescriptor d;
    Far::TopologyDescriptor::FVarChannel channel;
    channel.numValues = (int)(uvs.values.size() / 2);
    channel.valueIndices = uvs.indices.data();
    d.numVertices = (int)m.source.size();
    d.numFaces = (int)c->face_count;
    d.numVertsPerFace = (const int *)c->face_sizes;
    d.vertIndicesPerFace = (const int *)m.indices.data();
    d.numCreases = (int)m.crease_sharpness.size();
    d.creaseVertexIndexPairs = (const int *)m.crease_edges.data();
    d.creaseWeights = m.crease_sharpness.data();
    d.numCorners = (int)m.corners.size();
    d.cornerVertexIndices = (const int *)m.corners.data();
    d.cornerWeights = m.corner_sharpness.data();
    d.numFVarChannels = c->face_uvs ? 1 : 0;
    d.fvarChannels = &channel;
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Factory::Options settings(Sdc::SCHEME_CATMARK, options);
    settings.validateFullTopology = true;
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(d, settings));
    if (refiner) {
        // Level 0 takes its limit points from level 1, where they have the same limit.
        Far::TopologyRefiner::UniformOptions uniform((int)std::max(p->level, 1u));
        uniform.fullTopologyInLastLevel = true;
        refiner->RefineUniform(uniform);
    }
    return refiner;
}

// ---- limit rows ------------------------------------------------------------------------------------------

// A source of PrimvarRefiner::Limit: the stencil of a vertex of the last level.
struct StencilSource {
    const Far::StencilTableReal<float> *table;
    Far::StencilReal<float> operator[](int i) const
    {
        return table->GetStencil(i);
    }
};

// Sums one row at a time. Limit finishes a vertex before it begins the next, and clears the position first.
struct RowBuilder {
    Lists *rows;
    std::vector<Weights> *weights;
    const uint32_t *source;        // cage vertices of those of the topology
    std::vector<Weights> sums;     // by cage vertex
    std::vector<uint32_t> touched; // cage vertices of the row
    std::vector<bool> is_touched;
    bool open = false;

    RowBuilder(ng_refiner *r, const ng_manifold &m, size_t cage_vertices)
        : rows(&r->rows), weights(&r->weights), source(m.source.data()),
          sums(cage_vertices, Weights{0, 0, 0}), is_touched(cage_vertices)
    {
        rows->offsets.push_back(0);
    }
    void finish_row()
    {
        std::sort(touched.begin(), touched.end());
        for (uint32_t v : touched) {
            rows->items.push_back(v);
            weights->push_back(sums[v]);
            sums[v] = Weights{0, 0, 0};
            is_touched[v] = false;
        }
        touched.clear();
        if (open)
            rows->offsets.push_back((uint32_t)rows->items.size());
        open = false;
    }
    void add(const Far::StencilReal<float> &stencil, float w, float Weights::*part)
    {
        const float *stencil_weights = stencil.GetWeights();
        const Far::Index *sources = stencil.GetVertexIndices();
        for (int i = 0; i < stencil.GetSize(); i++) {
            uint32_t v = source[sources[i]];
            if (!is_touched[v]) {
                is_touched[v] = true;
                touched.push_back(v);
            }
            sums[v].*part += w * stencil_weights[i];
        }
    }
};

// A destination of PrimvarRefiner::Limit: one of the three weights of every row.
struct Part {
    RowBuilder *builder;
    float Weights::*part;

    Part &operator[](int)
    {
        return *this;
    }
    void Clear()
    {
        if (part != &Weights::position)
            return;
        builder->finish_row();
        builder->open = true;
    }
    void AddWithWeight(const Far::StencilReal<float> &stencil, float w)
    {
        builder->add(stencil, w, part);
    }
};

void make_rows(const Far::TopologyRefiner &topology, ng_refiner *r, const ng_manifold &m,
               size_t cage_vertices)
{
    Far::StencilTableFactoryReal<float>::Options options;
    options.generateIntermediateLevels = false;
    std::unique_ptr<const Far::StencilTableReal<float>> table(
        Far::StencilTableFactoryReal<float>::Create(topology, options));
    RowBuilder builder(r, m, cage_vertices);
    StencilSource source{table.get()};
    Part position{&builder, &Weights::position}, u{&builder, &Weights::u}, v{&builder, &Weights::v};
    Far::PrimvarRefiner(topology).Limit(source, position, u, v);
    builder.finish_row();
    r->rows.items.shrink_to_fit();
    r->weights.shrink_to_fit();
}

// ---- output vertices -------------------------------------------------------------------------------------

struct Uv {
    float x, y;
    void Clear()
    {
        x = y = 0;
    }
    void AddWithWeight(const Uv &other, float w)
    {
        x += w * other.x;
        y += w * other.y;
    }
};

// The UVs of a level: those of the cage refined down to it, and moved to their limit.
std::vector<Uv> refine_uvs(const Far::TopologyRefiner &topology, const Uvs &uvs, int level)
{
    std::vector<Uv> now(uvs.values.size() / 2);
    std::memcpy(now.data(), uvs.values.data(), uvs.values.size() * sizeof(float));
    Far::PrimvarRefiner primvars(topology);
    for (int i = 1; i <= level; i++) {
        std::vector<Uv> next((size_t)topology.GetLevel(i).GetNumFVarValues());
        primvars.InterpolateFaceVarying(i, now, next);
        now.swap(next);
    }
    if (level == 0)
        return now;
    std::vector<Uv> limit(now.size());
    primvars.LimitFaceVarying(now, limit);
    return limit;
}

// Corners of a level's faces, numbered through; corners of a vertex in one smooth sector have the same root.
class Sectors
{
  public:
    explicit Sectors(const Far::TopologyLevel &level)
        : level_(level), first_((size_t)level.GetNumFaces() + 1), parent_((size_t)level.GetNumFaceVertices())
    {
        for (int f = 0; f < level.GetNumFaces(); f++)
            first_[(size_t)f + 1] = first_[(size_t)f] + (uint32_t)level.GetFaceVertices(f).size();
        std::iota(parent_.begin(), parent_.end(), 0);
        for (int e = 0; e < level.GetNumEdges(); e++)
            if (level.GetEdgeFaces(e).size() == 2 && level.GetEdgeSharpness(e) < still_sharp)
                join_across(e);
    }
    uint32_t corner(int face, int i) const
    {
        return first_[(size_t)face] + (uint32_t)i;
    }
    uint32_t root(uint32_t c)
    {
        while (parent_[c] != c)
            c = parent_[c] = parent_[parent_[c]];
        return c;
    }

  private:
    uint32_t corner_of(int face, int vertex) const
    {
        return corner(face, level_.GetFaceVertices(face).FindIndex(vertex));
    }
    void join_across(int edge)
    {
        Far::ConstIndexArray faces = level_.GetEdgeFaces(edge), ends = level_.GetEdgeVertices(edge);
        for (int end = 0; end < 2; end++) {
            uint32_t a = root(corner_of(faces[0], ends[end])), b = root(corner_of(faces[1], ends[end]));
            parent_[std::max(a, b)] = std::min(a, b);
        }
    }
    const Far::TopologyLevel &level_;
    std::vector<uint32_t> first_, parent_;
};

class OutputBuilder
{
  public:
    OutputBuilder(const Far::TopologyRefiner &topology, int level, const Uvs &uvs, ng_refiner *r)
        : level_(topology.GetLevel(level)), sectors_(level_), r_(r), first_level_(level == 0)
    {
        has_uvs_ = !uvs.indices.empty();
        if (has_uvs_)
            uvs_ = refine_uvs(topology, uvs, level);
        count_sectors();
        for (int f = 0; f < level_.GetNumFaces(); f++)
            add_face(f);
        r->fans.build(r->row.size(), fan_keys_, fan_values_);
        r->sectors.build(sector_ids_.size(), sector_keys_, sector_values_);
    }

  private:
    // A vertex with corners of more than one root is on a crease.
    void count_sectors()
    {
        first_root_.assign((size_t)level_.GetNumVertices(), UINT32_MAX);
        divided_.assign((size_t)level_.GetNumVertices(), false);
        for (int f = 0; f < level_.GetNumFaces(); f++) {
            Far::ConstIndexArray vertices = level_.GetFaceVertices(f);
            for (int i = 0; i < vertices.size(); i++) {
                uint32_t root = sectors_.root(sectors_.corner(f, i)),
                         &first = first_root_[(size_t)vertices[i]];
                if (first == UINT32_MAX)
                    first = root;
                else if (first != root)
                    divided_[(size_t)vertices[i]] = true;
            }
        }
    }
    uint32_t output_vertex(int face, int i)
    {
        int vertex = level_.GetFaceVertices(face)[i];
        uint32_t root = sectors_.root(sectors_.corner(face, i));
        uint32_t uv = has_uvs_ ? (uint32_t)level_.GetFaceFVarValues(face)[i] : 0;
        auto found = outputs_.emplace((uint64_t)root << 32 | uv, (uint32_t)r_->row.size());
        if (found.second) {
            r_->row.push_back((uint32_t)(first_level_ ? level_.GetVertexChildVertex(vertex) : vertex));
            r_->uvs.push_back(has_uvs_ ? uvs_[uv].x : 0);
            r_->uvs.push_back(has_uvs_ ? uvs_[uv].y : 0);
            r_->sector.push_back(divided_[(size_t)vertex] ? sector_id(root) : UINT32_MAX);
        }
        return found.first->second;
    }
    uint32_t sector_id(uint32_t root)
    {
        return sector_ids_.emplace(root, (uint32_t)sector_ids_.size()).first->second;
    }
    void add_triangle(int face, const int corners[3])
    {
        uint32_t triangle = (uint32_t)(r_->indices.size() / 3);
        for (int k = 0; k < 3; k++) {
            uint32_t v = output_vertex(face, corners[k]);
            r_->indices.push_back(v);
            fan_keys_.push_back(v);
            fan_values_.push_back(triangle);
            if (r_->sector[v] != UINT32_MAX) {
                sector_keys_.push_back(r_->sector[v]);
                sector_values_.push_back(triangle);
            }
        }
    }
    void add_face(int face)
    {
        for (int i = 1; i + 1 < level_.GetFaceVertices(face).size(); i++) {
            const int corners[3] = {0, i, i + 1};
            add_triangle(face, corners);
        }
    }

    const Far::TopologyLevel &level_;
    Sectors sectors_;
    ng_refiner *r_;
    bool first_level_, has_uvs_;
    std::vector<Uv> uvs_;
    std::vector<uint32_t> first_root_; // by vertex
    std::vector<bool> divided_;        // by vertex
    std::unordered_map<uint64_t, uint32_t> outputs_;
    std::unordered_map<uint32_t, uint32_t> sector_ids_;
    std::vector<uint32_t> fan_keys_, fan_values_, sector_keys_, sector_values_;
};

ng_result build(const ng_cage *cage, const ng_refiner_params *params, char *why, ng_refiner *r)
{
    Uvs uvs;
    const ng_manifold manifold(cage);
    if (cage->face_uvs)
        uvs.build(cage);
    std::unique_ptr<Far::TopologyRefiner> topology = make_topology(cage, manifold, params, uvs);
    if (!topology) {
        std::snprintf(why, NG_REASON_SIZE, "its faces do not make a mesh that can be subdivided");
        return NG_ERROR_FORMAT;
    }
    make_rows(*topology, r, manifold, cage->vertex_count);
    OutputBuilder(*topology, (int)params->level, uvs, r);
    return NG_OK;
}

// ---- applying --------------------------------------------------------------------------------------------

struct Vec {
    float x, y, z;
};

Vec load(const float *p, size_t i)
{
    return {p[i * 3], p[i * 3 + 1], p[i * 3 + 2]};
}
Vec operator-(Vec a, Vec b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vec operator*(Vec a, float s)
{
    return {a.x * s, a.y * s, a.z * s};
}
void add(Vec *sum, Vec a, float s)
{
    sum->x += a.x * s;
    sum->y += a.y * s;
    sum->z += a.z * s;
}
float dot(Vec a, Vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec cross(Vec a, Vec b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// A unit vector, or false where the direction vanishes.
bool normalize(Vec *v)
{
    float length = std::sqrt(dot(*v, *v));
    if (!(length > 1e-20f) || !std::isfinite(length))
        return false;
    *v = *v * (1 / length);
    return true;
}
void store(float *p, size_t i, Vec v)
{
    p[i * 3] = v.x;
    p[i * 3 + 1] = v.y;
    p[i * 3 + 2] = v.z;
}

struct Job {
    const ng_refiner *r;
    const ng_refiner_vertices *v;
};

// Positions and limit normals: one row a vertex.
void apply_rows(void *user, uint32_t begin, uint32_t end, uint32_t)
{
    const Job *job = static_cast<const Job *>(user);
    const ng_refiner *r = job->r;
    for (size_t i = begin; i < end; i++) {
        Vec p = {0, 0, 0}, u = p, v = p;
        for (uint32_t k = r->rows.offsets[r->row[i]]; k < r->rows.offsets[r->row[i] + 1]; k++) {
            Vec cage = load(job->v->cage, r->rows.items[k]);
            add(&p, cage, r->weights[k].position);
            add(&u, cage, r->weights[k].u);
            add(&v, cage, r->weights[k].v);
        }
        Vec n = cross(u, v);
        if (!normalize(&n))
            n = {0, 0, 0}; // the facets decide
        store(job->v->positions, i, p);
        store(job->v->normals, i, n);
    }
}

Vec facet_normal(const Job *job, const uint32_t *begin, const uint32_t *end)
{
    Vec sum = {0, 0, 0};
    for (; begin < end; begin++) {
        const uint32_t *t = &job->r->indices[(size_t)*begin * 3];
        Vec a = load(job->v->positions, t[0]);
        add(&sum, cross(load(job->v->positions, t[1]) - a, load(job->v->positions, t[2]) - a), 1);
    }
    return normalize(&sum) ? sum : Vec{0, 1, 0};
}

const uint32_t *list(const Lists &lists, size_t i)
{
    return lists.items.data() + lists.offsets[i];
}

// Adds the directions in which a triangle's u and v grow.
void add_uv_directions(const Job *job, uint32_t triangle, Vec *u_sum, Vec *v_sum)
{
    const uint32_t *t = &job->r->indices[(size_t)triangle * 3];
    const float *uvs = job->r->uvs.data();
    Vec a = load(job->v->positions, t[0]);
    Vec e1 = load(job->v->positions, t[1]) - a, e2 = load(job->v->positions, t[2]) - a;
    float du1 = uvs[t[1] * 2] - uvs[t[0] * 2], dv1 = uvs[t[1] * 2 + 1] - uvs[t[0] * 2 + 1];
    float du2 = uvs[t[2] * 2] - uvs[t[0] * 2], dv2 = uvs[t[2] * 2 + 1] - uvs[t[0] * 2 + 1];
    float det = du1 * dv2 - du2 * dv1;
    if (!(std::fabs(det) > 1e-20f) || !std::isfinite(det))
        return;
    float sign = det > 0 ? 1.0f : -1.0f;
    add(u_sum, e1, sign * dv2);
    add(u_sum, e2, -sign * dv1);
    add(v_sum, e2, sign * du1);
    add(v_sum, e1, -sign * du2);
}

// The bitangent points against v, as in geometry.c.
void write_tangent(const Job *job, size_t i, Vec n)
{
    Vec t = {0, 0, 0}, b = t;
    const Lists &fans = job->r->fans;
    for (const uint32_t *f = list(fans, i); f < list(fans, i + 1); f++)
        add_uv_directions(job, *f, &t, &b);
    add(&t, n, -dot(n, t));
    if (!normalize(&t)) {
        t = std::fabs(n.x) < 0.9f ? Vec{1, 0, 0} : Vec{0, 1, 0};
        add(&t, n, -dot(n, t));
        normalize(&t);
    }
    float *out = job->v->tangents + i * 4;
    out[0] = t.x;
    out[1] = t.y;
    out[2] = t.z;
    out[3] = dot(cross(n, t), b) > 0 ? -1.0f : 1.0f;
}

// What needs the positions of neighbours: normals along creases, and tangents.
void apply_facets(void *user, uint32_t begin, uint32_t end, uint32_t)
{
    const Job *job = static_cast<const Job *>(user);
    const ng_refiner *r = job->r;
    for (size_t i = begin; i < end; i++) {
        Vec n = load(job->v->normals, i);
        if (r->sector[i] != UINT32_MAX)
            n = facet_normal(job, list(r->sectors, r->sector[i]), list(r->sectors, r->sector[i] + (size_t)1));
        else if (dot(n, n) == 0)
            n = facet_normal(job, list(r->fans, i), list(r->fans, i + 1));
        store(job->v->normals, i, n);
        if (job->v->tangents)
            write_tangent(job, i, n);
    }
}

} // namespace

ng_result ng_cage_check(const struct ng_cage *cage, struct ng_cage_report *out)
{
    *out = {};
    try {
        if (!check_cage(cage, out->why))
            return NG_ERROR_FORMAT;
        const ng_manifold manifold(cage);
        out->divided_edges = manifold.divided_edges;
        std::copy_n(manifold.first_edge, 2, out->first_edge);
        return NG_OK;
    } catch (const std::bad_alloc &) {
        return ng_out_of_memory("a cage");
    }
}

ng_result ng_refiner_create(const struct ng_cage *cage, const struct ng_refiner_params *params,
                            char why[NG_REASON_SIZE], struct ng_refiner **out)
{
    *out = nullptr;
    try {
        NG_TRY(check(cage, params, why));
        auto r = std::make_unique<ng_refiner>();
        NG_TRY(build(cage, params, why, r.get()));
        *out = r.release();
        return NG_OK;
    } catch (const std::bad_alloc &) {
        return ng_out_of_memory(params->name ? params->name : "a subdivided mesh");
    }
}

void ng_refiner_destroy(struct ng_refiner **r)
{
    delete *r;
    *r = nullptr;
}

struct ng_refiner_mesh ng_refiner_get_mesh(const struct ng_refiner *r)
{
    return {(uint32_t)r->row.size(), (uint32_t)r->indices.size(), r->indices.data(), r->uvs.data()};
}

size_t ng_refiner_memory(const struct ng_refiner *r)
{
    return sizeof *r + r->rows.bytes() + r->fans.bytes() + r->sectors.bytes() +
           r->weights.capacity() * sizeof(Weights) +
           (r->row.capacity() + r->sector.capacity() + r->indices.capacity()) * sizeof(uint32_t) +
           r->uvs.capacity() * sizeof(float);
}

void ng_refiner_apply(const struct ng_refiner *r, struct ng_jobs *jobs, const struct ng_refiner_vertices *v)
{
    const uint32_t grain = 512;
    Job job = {r, v};
    ng_jobs_for(jobs, (uint32_t)r->row.size(), grain, apply_rows, &job);
    ng_jobs_for(jobs, (uint32_t)r->row.size(), grain, apply_facets, &job);
}
