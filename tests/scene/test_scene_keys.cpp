#include <doctest/doctest.h>
#include <fmt/format.h>

#include <map>
#include <set>

#include "balance/partitioner.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_text.hpp"
#include "scene/scene_values.hpp"

using namespace moraine;

namespace {

/// What shows every key: a scene for all, what stands over terrain, and water.
constexpr const char* reference_scenes[] = {"/reference.toml", "/reference_terrain.toml", "/reference_water.toml"};

/// (table, law, key) -> the comment above it in a reference scene; the first one that is not empty.
class Reference {
  public:
    Reference() {
        for (const char* name : reference_scenes) {
            std::ifstream file(inputs_folder() + name);
            std::string line;
            while (std::getline(file, line)) read(line);
        }
    }

    std::string comment(const SceneKey& key) const {
        const std::string law = key.table == "material" && !key.only.empty() ? key.only.front() : "";
        const auto found = comments_.find(fmt::format("{}|{}|{}", key.table, law, key.name));
        return found == comments_.end() ? "" : found->second;
    }
    bool has(const SceneKey& key) const { return !comment(key).empty(); }

  private:
    void read(const std::string& line) {
        if (line.starts_with("[")) {
            const std::size_t first = line.find_first_not_of('[');
            table_ = line.substr(first, line.find(']') - first);
            law_.clear();
            block_.clear();
        } else if (const std::string key = key_of(line); !key.empty()) {
            if (table_ == "material" && key == "law") law_ = line.substr(line.find('"') + 1);
            if (!law_.empty() && law_.back() == '"') law_.pop_back();
            keep(fmt::format("{}||{}", table_, key));
            keep(fmt::format("{}|{}|{}", table_, law_, key));
            block_.clear();
        } else if (line.starts_with("# ")) {
            if (!block_.empty()) block_ += ' ';
            block_ += line.substr(2);
        } else {
            block_.clear();
        }
    }

    void keep(const std::string& at) {
        if (!block_.empty()) comments_.emplace(at, block_);
    }

    /// "cell" of "cell = 0.1" and of "# cell = 0.1"; a comment never has " = " after its first word.
    static std::string key_of(const std::string& line) {
        const std::string text = line.starts_with("# ") ? line.substr(2) : line;
        const std::size_t end = text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789");
        return end != std::string::npos && text.substr(end, 3) == " = " ? text.substr(0, end) : "";
    }

    std::string table_, law_, block_;
    std::map<std::string, std::string> comments_;
};

/// What stands for another key that the scene has, or would run code.
bool shown_as_comment(const SceneKey& key) {
    return key.name == "source" || key.name == "dt" || key.name == "profile" || key.name == "crop" ||
           (key.table == "material.su" && (key.name == "depth" || key.name == "value"));
}

}  // namespace

TEST_CASE("the reference scenes say of every key what the program knows") {
    const Reference reference;
    for (const SceneKey& key : all_scene_keys()) {
        CAPTURE(key.table);
        CAPTURE(key.name);
        CHECK(reference.comment(key) == describe(key));
    }
}

TEST_CASE("the reference scenes show a use of every key") {
    std::ostringstream text;
    for (const char* name : reference_scenes) text << std::ifstream(inputs_folder() + name).rdbuf();
    for (const SceneKey& key : all_scene_keys()) {
        CAPTURE(key.table);
        CAPTURE(key.name);
        CHECK(text.str().find(fmt::format("\n{}{} = ", shown_as_comment(key) ? "# " : "", key.name)) !=
              std::string::npos);
    }
}

TEST_CASE("every default is a valid value of its key") {
    for (const SceneKey& key : all_scene_keys()) {
        CAPTURE(key.table);
        CAPTURE(key.name);
        if (key.required() || key.standard->empty()) continue;
        CHECK_NOTHROW(standard_value(key, 2));
        CHECK_NOTHROW(standard_value(key, 3));
    }
}

TEST_CASE("no table has a key twice") {
    std::set<std::string> seen;
    for (const SceneKey& key : all_scene_keys()) {
        const std::string law = key.table == "material" && !key.only.empty() ? key.only.front() : "";
        CHECK(seen.insert(fmt::format("{}.{}.{}", key.table, law, key.name)).second);
    }
}

TEST_CASE("a law's keys do not hide those of every material") {
    for (const std::string& name : law_names())
        for (const Parameter& parameter : find_law(name)->parameters)
            for (const auto& row : material_rows()) CHECK(row.key.name != parameter.key);
}

TEST_CASE("a scene may name every partitioner of the program, and no other") {
    for (const auto& row : scene_rows())
        if (row.key.name == "partitioner") CHECK(row.key.choices == partitioner_names());
}
