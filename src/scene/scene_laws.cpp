#include "scene/scene_laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "compile/system_compiler.hpp"
#include "core/data/error.hpp"
#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_names.hpp"
#include "scene/scene_values.hpp"

namespace moraine {
namespace {

/// Keys and scalars of its own that would hide others.
std::string problem_of(const LawInfo& law) {
    const std::vector<std::string> fields = output_field_names({});
    for (const char* name : law.history_names)
        if (std::find(fields.begin(), fields.end(), name) != fields.end())
            return fmt::format("has a scalar {} (outputs have such a field). Rename it?", quote(name));
    std::vector<std::string> keys;
    for (const auto& row : material_rows()) keys.push_back(row.key.name);
    for (const Parameter& parameter : law.parameters) {
        if (std::find(keys.begin(), keys.end(), parameter.key) != keys.end())
            return fmt::format("has a parameter {} (a material has such a key, or it is there twice). Rename it?",
                               quote(parameter.key));
        keys.push_back(parameter.key);
    }
    return "";
}

void load(toml::value<std::string>& source, const std::string& material, const std::string& scene,
          const CodeRights& rights) {
    const std::string said = source.get(), place = place_of(source, scene),
                      key = fmt::format("material.{}.source = {}", material, quote(said));
    if (!rights.allowed)
        refuse(place, key, "it is code of whoever wrote the scene, and may do whatever you may",
               "Read it, and give --allow-code?");
    std::filesystem::path file = said;
    if (file.is_relative()) file = std::filesystem::path(scene).parent_path() / file;
    std::string problem;
    try {
        const std::string name = load_law(file, said, rights);
        problem = problem_of(*find_law(name));
        source = toml::value<std::string>(name);
    } catch (const CompilerError& error) {
        throw CompilerError(fmt::format("{}: {} {}", place, key, error.what()));
    } catch (const InputError& error) {
        problem = error.what();
    }
    if (!problem.empty()) throw InputError(fmt::format("{}: {} {}", place, key, problem));
}

}  // namespace

void load_laws(toml::table& root, const std::string& scene, const CodeRights& rights) {
    toml::array* materials = root["material"].as_array();
    int number = 0;
    if (materials)
        for (toml::node& item : *materials) {
            toml::table* table = item.as_table();
            ++number;
            if (!table || (*table)["law"].value_or(std::string()) != "file") continue;
            if (auto* source = (*table)["source"].as_string())
                load(*source, label_of(*table, "material", number), scene, rights);
        }
}

const LawInfo* law_of(const toml::table& material) {
    const std::string law = material["law"].value_or(std::string());
    return find_law(law == "file" ? material["source"].value_or(std::string()) : law);
}

}  // namespace moraine
