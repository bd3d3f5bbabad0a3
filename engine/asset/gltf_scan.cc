// The JSON of a glTF document, checked before tinygltf sees it.
//
// tinygltf builds its tree by recursion, turns large integers into small ones, and ignores a property of the
// wrong type as if it were absent. So the text first goes through an event parser, which bounds depth,
// number of values and size of integers, and holds every property of glTF 2.0 that is read against one
// table: which paths hold which kind of value. What the table does not name may be anything.
#include "asset/gltf_internal.h"
#include "base/log.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace
{

constexpr unsigned max_depth = 64;
constexpr size_t max_values = 4u << 20;
constexpr size_t max_objects = 1u << 20;   // tinygltf spends half a kilobyte on most of them
constexpr size_t max_materials = 1u << 16; // and two on a material
constexpr uint64_t max_json = 512u << 20;
constexpr uint64_t max_integer = UINT32_MAX;
constexpr size_t max_shown = 60; // bytes of the file's strings in a message

enum Kind { ANY, ARRAY, OBJECT, STRING, BOOLEAN, NUMBER, INTEGER, COUNT, INDEX };

const char *const kind_names[] = {
    "anything",
    "an array",
    "an object",
    "a string",
    "true or false",
    "a number",
    "a whole number",
    "a whole number >= 0",
    "an index (a whole number >= 0)",
};

// The leaves; what contains them follows from the path: "a[].b" makes "a" an array and "a[]" an object. "*"
// is any other member. Not listed are those that every object may have: "extensions", "extras", and in the
// document's own arrays "name".
const struct {
    Kind kind;
    std::initializer_list<const char *> paths;
} leaves[] = {
    {INDEX,
     {"scene",
      "accessors[].bufferView",
      "accessors[].sparse.indices.bufferView",
      "accessors[].sparse.values.bufferView",
      "animations[].channels[].sampler",
      "animations[].channels[].target.node",
      "animations[].samplers[].input",
      "animations[].samplers[].output",
      "bufferViews[].buffer",
      "images[].bufferView",
      "materials[].emissiveTexture.index",
      "materials[].normalTexture.index",
      "materials[].occlusionTexture.index",
      "materials[].pbrMetallicRoughness.baseColorTexture.index",
      "materials[].pbrMetallicRoughness.metallicRoughnessTexture.index",
      "meshes[].primitives[].attributes.*",
      "meshes[].primitives[].indices",
      "meshes[].primitives[].material",
      "meshes[].primitives[].targets[].*",
      "nodes[].camera",
      "nodes[].children[]",
      "nodes[].extensions.KHR_lights_punctual.light",
      "nodes[].mesh",
      "nodes[].skin",
      "scenes[].nodes[]",
      "skins[].inverseBindMatrices",
      "skins[].joints[]",
      "skins[].skeleton",
      "textures[].sampler",
      "textures[].source"}},
    {COUNT,
     {"accessors[].byteOffset", "accessors[].count", "accessors[].sparse.count",
      "accessors[].sparse.indices.byteOffset", "accessors[].sparse.values.byteOffset",
      "bufferViews[].byteLength", "bufferViews[].byteOffset", "bufferViews[].byteStride",
      "buffers[].byteLength", "materials[].emissiveTexture.texCoord", "materials[].normalTexture.texCoord",
      "materials[].occlusionTexture.texCoord", "materials[].pbrMetallicRoughness.baseColorTexture.texCoord",
      "materials[].pbrMetallicRoughness.metallicRoughnessTexture.texCoord"}},
    {INTEGER,
     {"accessors[].componentType", "accessors[].sparse.indices.componentType", "bufferViews[].target",
      "meshes[].primitives[].mode", "samplers[].magFilter", "samplers[].minFilter", "samplers[].wrapS",
      "samplers[].wrapT"}},
    {NUMBER,
     {"accessors[].max[]",
      "accessors[].min[]",
      "cameras[].orthographic.xmag",
      "cameras[].orthographic.ymag",
      "cameras[].orthographic.zfar",
      "cameras[].orthographic.znear",
      "cameras[].perspective.aspectRatio",
      "cameras[].perspective.yfov",
      "cameras[].perspective.zfar",
      "cameras[].perspective.znear",
      "extensions.KHR_lights_punctual.lights[].color[]",
      "extensions.KHR_lights_punctual.lights[].intensity",
      "extensions.KHR_lights_punctual.lights[].range",
      "extensions.KHR_lights_punctual.lights[].spot.innerConeAngle",
      "extensions.KHR_lights_punctual.lights[].spot.outerConeAngle",
      "materials[].alphaCutoff",
      "materials[].emissiveFactor[]",
      "materials[].extensions.KHR_materials_emissive_strength.emissiveStrength",
      "materials[].normalTexture.scale",
      "materials[].occlusionTexture.strength",
      "materials[].pbrMetallicRoughness.baseColorFactor[]",
      "materials[].pbrMetallicRoughness.metallicFactor",
      "materials[].pbrMetallicRoughness.roughnessFactor",
      "meshes[].weights[]",
      "nodes[].matrix[]",
      "nodes[].rotation[]",
      "nodes[].scale[]",
      "nodes[].translation[]",
      "nodes[].weights[]"}},
    {STRING,
     {"accessors[].type", "animations[].channels[].target.path", "animations[].samplers[].interpolation",
      "asset.copyright", "asset.generator", "asset.minVersion", "asset.version", "buffers[].uri",
      "cameras[].type", "extensions.KHR_lights_punctual.lights[].name",
      "extensions.KHR_lights_punctual.lights[].type", "extensionsRequired[]", "extensionsUsed[]",
      "images[].mimeType", "images[].uri", "materials[].alphaMode"}},
    {BOOLEAN, {"accessors[].normalized", "materials[].doubleSided"}},
};

// What may stand at a place of the document: a tree by the names of members, so that a step down costs no
// more than its own name, however long the names above it are.
struct Rule {
    Kind kind = ANY;
    std::unordered_map<std::string, std::unique_ptr<Rule>> members;
    std::unique_ptr<Rule> item;

    Rule *member(const std::string &name)
    {
        auto &rule = members[name];
        if (!rule)
            rule = std::make_unique<Rule>();
        return rule.get();
    }
    void be_object()
    {
        kind = OBJECT;
        member("extensions")->kind = OBJECT;
        member("extensions")->member("*")->kind = OBJECT;
    }
    // Makes an array of it; the objects of the document's own arrays have names.
    Rule *be_array(bool top)
    {
        kind = ARRAY;
        if (!item)
            item = std::make_unique<Rule>();
        if (top)
            item->member("name")->kind = STRING;
        return item.get();
    }
    const Rule *find(const std::string &name) const
    {
        auto found = members.find(name);
        if (found == members.end())
            found = members.find("*");
        return found == members.end() ? nullptr : found->second.get();
    }
};

// One step of a path: "b[]" of "a[].b[].c".
Rule *step_down(Rule *rule, std::string name, bool top)
{
    rule->be_object();
    bool array = name.size() > 2 && name.compare(name.size() - 2, 2, "[]") == 0;
    if (!array)
        return rule->member(name);
    name.resize(name.size() - 2);
    return rule->member(name)->be_array(top);
}

std::unique_ptr<Rule> make_rules()
{
    auto root = std::make_unique<Rule>();
    for (const auto &group : leaves)
        for (const std::string path : group.paths) {
            Rule *rule = root.get();
            for (size_t begin = 0, end; begin < path.size(); begin = end + 1) {
                end = std::min(path.find('.', begin), path.size());
                rule = step_down(rule, path.substr(begin, end - begin), begin == 0);
            }
            rule->kind = group.kind;
        }
    return root;
}

// The places that the scan looks at itself.
struct Places {
    std::unique_ptr<Rule> root = make_rules();
    const Rule *version = root->find("asset")->find("version");
    const Rule *min_version = root->find("asset")->find("minVersion");
    const Rule *buffer = root->find("buffers")->item.get();
    const Rule *view = root->find("bufferViews")->item.get();
    const Rule *accessor = root->find("accessors")->item.get();
    const Rule *material = root->find("materials")->item.get();
};

const Places &known_places()
{
    static const Places places;
    return places;
}

std::string shortened(const std::string &text)
{
    if (text.size() <= max_shown)
        return text;
    size_t end = max_shown;
    while (end > 0 && ((unsigned char)text[end] & 0xc0) == 0x80)
        end--;
    return text.substr(0, end) + "...";
}

class Scan : public nlohmann::json_sax<nlohmann::json>
{
  public:
    std::string error, version, min_version;
    gltf_counts counts = {};

    bool null() override
    {
        return leaf(ANY, "null", !scene_depth || fail_here("null where a value is needed"));
    }
    bool boolean(bool v) override
    {
        return leaf(BOOLEAN, v ? "true" : "false");
    }
    bool number_integer(number_integer_t v) override
    {
        std::string text = std::to_string(v);
        return leaf(INTEGER, text, in_range(v >= INT32_MIN, text));
    }
    bool number_unsigned(number_unsigned_t v) override
    {
        std::string text = std::to_string(v);
        return leaf(v <= INT32_MAX ? INDEX : COUNT, text, in_range(v <= max_integer, text));
    }
    bool number_float(number_float_t v, const string_t &text) override
    {
        return leaf(NUMBER, shortened(text), in_range(std::isfinite(v), shortened(text)));
    }
    bool string(string_t &text) override
    {
        enter();
        if (rule == places.version)
            version = text;
        else if (rule == places.min_version)
            min_version = text;
        bool ok = no_zero(text) && count() && check(STRING, "a string");
        leave();
        return ok;
    }
    bool binary(binary_t &) override
    {
        return leaf(ANY, "bytes");
    }
    bool start_object(std::size_t) override
    {
        return open(OBJECT);
    }
    bool end_object() override
    {
        return close();
    }
    bool start_array(std::size_t) override
    {
        return open(ARRAY);
    }
    bool end_array() override
    {
        return close();
    }
    bool key(string_t &name) override
    {
        if (!extras_depth && name == "extras")
            extras_depth = levels.size();
        else if (extras_depth == levels.size())
            extras_depth = 0;
        if (!scene_depth && name == "NG_scene" && levels.back().is_extensions)
            scene_depth = levels.size();
        else if (scene_depth == levels.size())
            scene_depth = 0;
        is_extensions = name == "extensions";
        rule = levels.back().rule && !extras_depth ? levels.back().rule->find(name) : nullptr;
        path += levels.size() > 1 ? "." + shortened(name) : shortened(name);
        return no_zero(name);
    }
    bool parse_error(std::size_t position, const std::string &, const nlohmann::detail::exception &e) override
    {
        const char *reason = std::strstr(e.what(), "parse error");
        return fail("malformed JSON at byte " + std::to_string(position) + ": " +
                    std::string(reason ? reason : e.what()).substr(0, 4 * max_shown));
    }

  private:
    // An array or object that is open, and where the paths return to after each of its items.
    struct Level {
        bool array, is_extensions;
        size_t index, path;
        const Rule *rule;
    };
    const Places &places = known_places();
    std::vector<Level> levels;
    std::string path;                         // of the current value, for messages: "nodes[2].mesh"
    const Rule *rule = places.root.get();     // of the current value; null: it may be anything
    bool is_extensions = false;               // the current value is a member "extensions"
    size_t extras_depth = 0, scene_depth = 0; // levels in whose member "extras", "NG_scene" this is; 0: not
    size_t values = 0, objects = 0, materials = 0;

    bool fail(std::string why)
    {
        error = std::move(why);
        return false;
    }
    bool fail_here(const std::string &why)
    {
        return fail((path.empty() ? "the document" : path) + ": " + why);
    }
    bool more(size_t *counter, size_t limit, const char *what)
    {
        return ++*counter <= limit || fail("JSON of more than " + std::to_string(limit) + " " + what);
    }
    bool count()
    {
        return more(&values, max_values, "values");
    }
    bool in_range(bool fits, const std::string &text)
    {
        return fits || extras_depth || fail("the integer " + text + " is out of range");
    }
    bool no_zero(const std::string &text)
    {
        return text.find('\0') == std::string::npos || extras_depth ||
               fail_here("a string holds the character \\u0000");
    }

    void enter()
    {
        if (levels.empty() || !levels.back().array)
            return; // key() has been here
        path += "[" + std::to_string(levels.back().index++) + "]";
        rule = levels.back().rule ? levels.back().rule->item.get() : nullptr;
        is_extensions = false;
    }
    void leave()
    {
        path.resize(levels.empty() ? 0 : levels.back().path);
    }

    // Kinds of numbers are in the order of what they allow: an index is a count, a count is an integer, ...
    bool check(Kind found, const std::string &shown)
    {
        Kind wanted = rule ? rule->kind : ANY;
        if (wanted == ANY || found == wanted || (wanted >= NUMBER && found > wanted))
            return true;
        return fail_here(shown + " where " + kind_names[wanted] + " is needed");
    }
    bool leaf(Kind found, const std::string &shown, bool ok = true)
    {
        enter();
        ok = ok && count() && check(found, shown);
        leave();
        return ok;
    }
    bool open(Kind kind)
    {
        enter();
        if (!check(kind, kind_names[kind]) || !count())
            return false;
        if (kind == OBJECT && !more(&objects, max_objects, "objects"))
            return false;
        if (rule && rule == places.material && !more(&materials, max_materials, "materials"))
            return false;
        counts.buffers += rule == places.buffer;
        counts.views += rule == places.view;
        counts.accessors += rule == places.accessor;
        levels.push_back({kind == ARRAY, is_extensions, 0, path.size(), rule});
        return levels.size() <= max_depth ||
               fail("JSON nested deeper than " + std::to_string(max_depth) + " levels");
    }
    bool close()
    {
        levels.pop_back();
        if (levels.size() < extras_depth)
            extras_depth = 0;
        if (levels.size() < scene_depth)
            scene_depth = 0;
        leave();
        return true;
    }
};

// glTF 2.0, 5.9 (asset): minVersion, if it is there, says what is needed, else the major part of version.
ng_result check_version(const char *path, const Scan &scan)
{
    if (scan.version.empty()) {
        ng_log_error("%s: asset.version: is missing; glTF 2.0 requires it", path);
        return NG_ERROR_FORMAT;
    }
    bool has_min = !scan.min_version.empty();
    const std::string &needed = has_min ? scan.min_version : scan.version;
    unsigned major = 0, minor = 0;
    char rest = 0;
    if (std::sscanf(needed.c_str(), "%4u.%4u%c", &major, &minor, &rest) == 2 && major == 2 &&
        (!has_min || minor == 0))
        return NG_OK;
    ng_log_error("%s: asset.%s: \"%s\" is not supported, glTF 2.0 is", path,
                 has_min ? "minVersion" : "version", shortened(needed).c_str());
    return NG_ERROR_UNSUPPORTED;
}

} // namespace

ng_result ng_gltf_scan(const char *path, const char *text, size_t size, gltf_counts *counts)
{
    if (size > max_json) {
        ng_log_error("%s: JSON of %zu bytes, more than the limit of %llu", path, size,
                     (unsigned long long)max_json);
        return NG_ERROR_FORMAT;
    }
    Scan scan;
    if (!nlohmann::json::sax_parse(text, text + size, &scan)) {
        ng_log_error("%s: %s", path, scan.error.c_str());
        return NG_ERROR_FORMAT;
    }
    *counts = scan.counts;
    return check_version(path, scan);
}
