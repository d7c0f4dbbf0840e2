#include "scene/scene_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/input_error.hpp"

namespace moraine {

std::string read_scene_file(const std::string& path) {
    std::error_code unknown;
    if (std::filesystem::is_directory(path, unknown))
        refuse(path, "the scene cannot be read", "it is a directory", "Is the path right?");
    errno = 0;
    std::ifstream file(path);
    std::ostringstream text;
    if (file && file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
    if (!file.is_open() || file.bad())
        refuse(path, "the scene cannot be read", std::strerror(errno), "Is the path right?");
    return text.str();
}

}  // namespace moraine
