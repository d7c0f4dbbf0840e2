#include "scene/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "io/input_error.hpp"

namespace moraine {
namespace {

constexpr std::size_t most_bytes = std::size_t(4) << 20;

/// The end of the string that begins at `at`, one behind its last quote.
std::size_t behind_string(const std::string& text, std::size_t at) {
    const char quote = text[at];
    const std::string three(3, quote);
    const bool many_lines = text.compare(at, 3, three) == 0;
    for (std::size_t i = at + (many_lines ? 3 : 1); i < text.size(); ++i) {
        if (quote == '"' && text[i] == '\\')
            ++i;
        else if (many_lines ? text.compare(i, 3, three) == 0 : text[i] == quote || text[i] == '\n')
            return i + (many_lines ? 3 : 1);
    }
    return text.size();
}

}  // namespace

std::string read_scene_file(const std::string& path) {
    std::error_code unknown;
    if (std::filesystem::is_directory(path, unknown))
        refuse(path, "the scene cannot be read", "it is a directory", "Is the path right?");
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::string text(most_bytes + 1, '\0');
    if (file) file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!file.is_open() || file.bad())
        refuse(path, "the scene cannot be read", std::strerror(errno), "Is the path right?");
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (text.size() > most_bytes)
        refuse(path, "the scene cannot be read", "it has more than 4 MiB",
               "Is this a scene? Particles can be a table, body.file?");
    return text;
}

void refuse_deep_keys(const std::string& text, const std::string& path) {
    int line = 1, levels = 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
        if (c == '"' || c == '\'') {
            const std::size_t end = behind_string(text, i);
            line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                                text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
            i = end - 1;
        }
        if (c == '\n') ++line;
        if (c == '.') ++levels;
        if (std::strchr("=,[]{}\n", c)) levels = 1;
        if (levels > deepest_key)
            refuse(fmt::format("{}:{}", path, line), "the key is too deep",
                   fmt::format("more than {} levels", deepest_key), "Is it a key of inputs/reference.toml?");
    }
}

}  // namespace moraine
