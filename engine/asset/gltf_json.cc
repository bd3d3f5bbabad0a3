// The JSON of a glTF document as a tree of values.
//
// An event parser bounds depth and number of values, and holds every property of glTF 2.0 against one table:
// which paths hold which kind of value. What the table does not name may be anything. A property of the wrong
// kind costs that property.
#include "asset/gltf_internal.h"
#include "base/log.h"
#include "base/printable.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace
{

constexpr unsigned max_depth = 64;
constexpr size_t max_values = 4u << 20;
constexpr uint64_t max_json = 512u << 20;
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
      "nodes[].extensions.EXT_mesh_gpu_instancing.attributes.*",
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

const Rule *known_rules()
{
    static const std::unique_ptr<Rule> rules = make_rules();
    return rules.get();
}

// Of the version alone a number is taken as the text that it should be.
const Rule *version_rule()
{
    static const Rule *const rule = known_rules()->find("asset")->find("version");
    return rule;
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

// Begins the strings that stand for numbers that JSON does not have, until they are left out: no text of a
// glTF holds a zero.
constexpr std::string_view no_number("\0\0", 2);

// The narrowest kind that a number is of: 4.0 is a whole number (glTF 2.0, 2.7).
Kind number_kind(double v)
{
    if (v != std::floor(v) || v < INT32_MIN || v > UINT32_MAX)
        return NUMBER;
    return v < 0 ? INTEGER : v <= INT32_MAX ? INDEX : COUNT;
}

class Scan : public nlohmann::json_sax<nlohmann::json>
{
  public:
    std::string error;
    bool malformed = false;       // what is no JSON
    std::vector<gltf_value> done; // items of what is open; at the end the document

    Scan(gltf_faults *faults_, ng_arena *arena_) : faults(faults_), arena(arena_)
    {
    }
    bool null() override
    {
        return leaf(ANY, gltf_value(), "null");
    }
    bool boolean(bool v) override
    {
        gltf_value value = {};
        value.kind = GLTF_BOOL;
        value.boolean = v;
        return leaf(BOOLEAN, value, v ? "true" : "false");
    }
    bool number_integer(number_integer_t v) override
    {
        return number((double)v, std::to_string(v));
    }
    bool number_unsigned(number_unsigned_t v) override
    {
        return number((double)v, std::to_string(v));
    }
    bool number_float(number_float_t v, const string_t &text) override
    {
        return number(v, shortened(text));
    }
    bool string(string_t &text) override
    {
        if (!skipped && text.compare(0, no_number.size(), no_number) == 0)
            return leaf(ANY, gltf_value(), shortened(text.substr(no_number.size())));
        if (!skipped && text.find('\0') != std::string::npos)
            return leaf(ANY, gltf_value(), "a string that holds the character \\u0000");
        return leaf(STRING, text_value(text), "a string");
    }
    bool binary(binary_t &) override
    {
        return leaf(ANY, gltf_value(), "bytes");
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
        if (skipped)
            return true;
        rule = levels.back().rule ? levels.back().rule->find(name) : nullptr;
        path += levels.size() > 1 ? "." + shortened(name) : shortened(name);
        next_key = copy_key(name);
        return true;
    }
    bool parse_error(std::size_t position, const std::string &, const nlohmann::detail::exception &e) override
    {
        const char *reason = std::strstr(e.what(), "parse error");
        malformed = true;
        return fail("malformed JSON at byte " + std::to_string(position) + ": " +
                    std::string(reason ? reason : e.what()).substr(0, 4 * max_shown));
    }

  private:
    // An array or object that is open.
    struct Level {
        bool array;
        size_t index, path; // of the next item; where the path returns to after each of its items
        const Rule *rule;
        const char *key;
        size_t first; // of its items in `done`
    };
    gltf_faults *faults;
    ng_arena *arena;
    std::vector<Level> levels;
    std::string path;                 // of the current value, for messages: "nodes[2].mesh"
    const Rule *rule = known_rules(); // of the current value; null: it may be anything
    const char *next_key = nullptr;
    size_t skipped = 0; // levels open within a value that is left out
    size_t values = 0;

    bool fail(std::string why)
    {
        error = std::move(why);
        return false;
    }
    bool count()
    {
        return ++values <= max_values || fail("JSON of more than " + std::to_string(max_values) + " values");
    }
    // A name with a zero is none that anybody knows: there it ends as no other name does.
    const char *copy_key(std::string &name)
    {
        size_t zero = name.find('\0');
        if (zero != std::string::npos)
            name.replace(zero, std::string::npos, "\\u0000");
        return copy(name);
    }
    const char *copy(const std::string &text)
    {
        const char *copied = ng_arena_string(arena, text.c_str());
        if (!copied)
            throw std::bad_alloc();
        return copied;
    }
    gltf_value text_value(const std::string &text)
    {
        gltf_value value = {};
        value.kind = GLTF_STRING;
        value.string = skipped ? "" : copy(text);
        return value;
    }
    bool number(double v, const std::string &text)
    {
        if (!skipped && rule == version_rule()) {
            char shown[32];
            std::snprintf(shown, sizeof shown, "%.1f", v);
            return leaf(STRING, text_value(shown), text);
        }
        gltf_value value = {};
        value.kind = GLTF_NUMBER;
        value.number = v;
        return leaf(number_kind(v), value, text);
    }

    void enter()
    {
        if (levels.empty() || !levels.back().array)
            return; // key() has been here
        path += "[" + std::to_string(levels.back().index++) + "]";
        rule = levels.back().rule ? levels.back().rule->item.get() : nullptr;
        next_key = nullptr;
    }
    void leave()
    {
        path.resize(levels.empty() ? 0 : levels.back().path);
    }

    // Kinds of numbers are in the order of what they allow: an index is a count, a count is an integer, ...
    bool fits(Kind found) const
    {
        Kind wanted = rule ? rule->kind : ANY;
        return wanted == ANY || found == wanted || (wanted >= NUMBER && found > wanted);
    }
    // Puts nothing in the place of a value that does not fit.
    bool leave_out(const std::string &shown)
    {
        gltf_value nothing = {};
        nothing.key = next_key;
        done.push_back(nothing);
        if (levels.empty())
            return fail("the document: " + shown + " where " + kind_names[rule->kind] + " is needed");
        return ng_gltf_fault_of_kind(faults, rule, "it is left out", "%s: %s where %s is needed",
                                     path.c_str(), shown.c_str(), kind_names[rule->kind]) != NG_ERROR_MEMORY;
    }
    bool leaf(Kind found, gltf_value value, const std::string &shown)
    {
        if (skipped)
            return count();
        enter();
        bool ok = count();
        value.key = next_key;
        if (fits(found))
            done.push_back(value);
        else
            ok = ok && leave_out(shown);
        leave();
        return ok;
    }
    bool open(Kind kind)
    {
        if (levels.size() + skipped >= max_depth)
            return fail("JSON nested deeper than " + std::to_string(max_depth) + " levels");
        if (skipped) {
            skipped++;
            return count();
        }
        enter();
        if (!count())
            return false;
        if (!fits(kind)) {
            skipped = 1;
            bool ok = leave_out(kind_names[kind]);
            leave();
            return ok;
        }
        levels.push_back({kind == ARRAY, 0, path.size(), rule, next_key, done.size()});
        return true;
    }
    bool close()
    {
        if (skipped) {
            skipped--;
            return true;
        }
        const Level level = levels.back();
        levels.pop_back();
        gltf_value value = {};
        value.kind = level.array ? GLTF_ARRAY : GLTF_OBJECT;
        value.key = level.key;
        value.count = (uint32_t)(done.size() - level.first);
        gltf_value *items = static_cast<gltf_value *>(ng_arena_array(arena, value.count, sizeof *items));
        if (!items)
            throw std::bad_alloc();
        std::copy(done.begin() + (std::ptrdiff_t)level.first, done.end(), items);
        value.items = items;
        done.resize(level.first);
        done.push_back(value);
        leave();
        return true;
    }
};

// ---- what is no JSON -------------------------------------------------------------------------------------
// A text with what JSON does not have put right: some writers put NaN and Infinity where it has null, names
// in Latin-1, paths with single backslashes, and halves of characters. A zero byte follows the text.
class Repair
{
  public:
    std::string out;
    size_t characters = 0; // that were wrong

    Repair(const char *begin, const char *end_, bool exact_) : at(begin), end(end_), exact(exact_)
    {
        out.reserve((size_t)(end - begin));
        while (at < end)
            if (*at == '"')
                put_string();
            else if (std::isalnum((unsigned char)*at) || *at == '-')
                put_word();
            else
                out += *at++;
    }

  private:
    const char *at, *const end;
    const bool exact; // numbers beyond all doubles and halves of characters stay, which JSON has

    void put_word()
    {
        const char *begin = at++;
        while (at < end && *at && (std::isalnum((unsigned char)*at) || std::strchr("+-.", *at)))
            at++;
        const std::string word(begin, at);
        bool none = word == "NaN" || word == "Infinity" || word == "-Infinity" || word == "-NaN";
        bool number = std::isdigit((unsigned char)word.back()) && !std::isalpha((unsigned char)word[0]);
        if (!none && (exact || !number || !std::isinf(std::strtod(word.c_str(), nullptr))))
            out += word;
        else if (exact)
            out += "null";
        else
            out += "\"\\u0000\\u0000" + word + "\""; // no_number, for messages
    }
    void put_string()
    {
        out += *at++;
        while (at < end && *at != '"')
            if (*at == '\\')
                put_escape();
            else
                put_character();
        if (at < end)
            out += *at++;
    }
    // Those of UTF-8 as they are, other bytes as Latin-1. Control characters are escaped.
    void put_character()
    {
        const char *begin = at;
        uint32_t c = ng_next_character(&at);
        if (c != NG_NO_CHARACTER && c >= ' ') {
            out.append(begin, at);
            return;
        }
        characters++;
        char escaped[8];
        std::snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)(unsigned char)*begin);
        out += escaped;
    }
    // The number of \uXXXX; NG_NO_CHARACTER: there is none here.
    uint32_t escaped_unit(const char *p) const
    {
        if (end - p < 6 || p[0] != '\\' || p[1] != 'u')
            return NG_NO_CHARACTER;
        uint32_t unit = 0;
        for (int i = 2; i < 6; i++) {
            if (!std::isxdigit((unsigned char)p[i]))
                return NG_NO_CHARACTER;
            unit = unit * 16 +
                   (uint32_t)(std::isdigit((unsigned char)p[i]) ? p[i] - '0' : (p[i] | 32) - 'a' + 10);
        }
        return unit;
    }
    // Halves of characters stand for none; a backslash that begins no escape stands for itself.
    void put_escape()
    {
        uint32_t unit = escaped_unit(at);
        uint32_t second = unit == NG_NO_CHARACTER ? unit : escaped_unit(at + 6);
        bool high = unit >= 0xd800 && unit < 0xdc00, low = unit >= 0xdc00 && unit < 0xe000;
        size_t size = unit == NG_NO_CHARACTER ? 2 : high && second >= 0xdc00 && second < 0xe000 ? 12 : 6;
        if (size == 2 && (end - at < 2 || !at[1] || !std::strchr("\"\\/bfnrt", at[1]))) {
            out += "\\\\";
            size = 1;
            characters++;
        } else if (size == 6 && (high || low) && !exact) {
            out += "\\ufffd";
            characters++;
        } else {
            out.append(at, size);
        }
        at += size;
    }
};

bool scan_text(Scan *scan, const char *text, size_t size)
{
    return nlohmann::json::sax_parse(text, text + size, scan);
}

ng_result parse(gltf_faults *faults, const char *text, size_t size, ng_arena *arena, const gltf_value **root)
{
    Scan scan(faults, arena), again(faults, arena);
    bool ok = scan_text(&scan, text, size);
    if (!ok && scan.malformed && !faults->strict) {
        const Repair repair(text, text + size, false);
        ng_gltf_faults_finish(faults); // they are met again
        ok = repair.out.compare(0, std::string::npos, text, size) != 0 &&
             scan_text(&again, repair.out.data(), repair.out.size());
        scan.done = ok ? again.done : scan.done;
        if (ok && repair.characters &&
            ng_gltf_fault(faults, "they are replaced", "its JSON has %zu characters that JSON does not have",
                          repair.characters) != NG_OK)
            throw std::bad_alloc();
    }
    if (!ok) {
        ng_log_error("%s: %s", faults->path, scan.error.c_str());
        return NG_ERROR_FORMAT;
    }
    gltf_value *document = static_cast<gltf_value *>(ng_arena_array(arena, 1, sizeof *document));
    if (!document)
        throw std::bad_alloc();
    *document = scan.done[0];
    *root = document;
    return NG_OK;
}

} // namespace

ng_result ng_gltf_json(gltf_faults *faults, const char *text, size_t size, ng_arena *arena,
                       const gltf_value **root)
{
    if (size > max_json) {
        ng_log_error("%s: JSON of %zu bytes, more than the limit of %llu", faults->path, size,
                     (unsigned long long)max_json);
        return NG_ERROR_FORMAT;
    }
    try {
        return parse(faults, text, size, arena, root);
    } catch (const std::exception &) {
        return ng_out_of_memory(faults->path);
    }
}

char *ng_gltf_plain_json(const char *text, size_t size, size_t *out_size)
{
    try {
        const Repair repair(text, text + size, true);
        *out_size = repair.out.size();
        char *copy = static_cast<char *>(std::malloc(repair.out.size() + 1));
        return copy ? static_cast<char *>(std::memcpy(copy, repair.out.c_str(), repair.out.size() + 1))
                    : nullptr;
    } catch (const std::exception &) {
        return nullptr;
    }
}

size_t ng_gltf_number_text(double v, char out[NG_GLTF_NUMBER_SIZE])
{
    constexpr double exact = 9007199254740992; // 2^53
    char *end = out + NG_GLTF_NUMBER_SIZE;
    if (v == 0 && std::signbit(v)) // -0 would read back as a whole number, which has no sign
        return (size_t)(std::copy_n("-0.0", 4, out) - out);
    bool whole = std::fabs(v) < exact && v == std::floor(v);
    return (size_t)((whole ? std::to_chars(out, end, (int64_t)v) : std::to_chars(out, end, v)).ptr - out);
}
