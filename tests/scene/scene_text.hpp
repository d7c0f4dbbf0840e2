#pragma once
// A good scene as text, and what the reader says when a part of it is replaced.

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/data/error.hpp"
#include "scene/read_scene.hpp"

namespace moraine {

inline const std::string good_scene = R"(title = "good"
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [4.0, 2.0]
cell = 0.1
[time]
end = 1.0
cfl = 0.4
[output]
fields = ["velocity"]
[[material]]
name = "clay"
law = "von-mises"
density = 1600.0
young = 5.0e5
poisson = 0.45
su = 2.0e3
[[body]]
name = "block"
material = "clay"
shape = "box"
min = [0.0, 0.0]
max = [1.0, 1.0]
[[body]]
name = "disk"
material = "clay"
shape = "sphere"
center = [2.0, 1.0]
radius = 0.5
[[wall]]
face = "y-min"
kind = "friction"
friction = 0.3
)";

/// A folder of this test program that is gone with it.
class TestFolder {
  public:
    TestFolder() : path_(std::filesystem::temp_directory_path() / ("moraine-test-" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;

    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(path_ / name) << text;
        return (path_ / name).string();
    }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::logic_error("the good scene has no " + from);
    return text.replace(at, from.size(), to);
}

inline Scene read_text(const std::string& text, const std::vector<std::string>& sets = {}) {
    const TestFolder folder;
    return read_scene(folder.write("scene.toml", text), sets);
}

/// What is said about the text, from the file's name on; empty if it is good.
inline std::string said_about(const std::string& text, const std::vector<std::string>& sets = {}) {
    try {
        read_text(text, sets);
    } catch (const InputError& e) {
        const std::string message = e.what();
        const std::size_t at = message.find("scene.toml");
        return at == std::string::npos ? message : message.substr(at);
    }
    return "";
}

/// What is said when the first `from` of the good scene is `to`.
inline std::string said_of(const std::string& from, const std::string& to) {
    return said_about(replaced(good_scene, from, to));
}

/// The same of a value that comes by --set.
inline std::string said_of_set(const std::string& assignment) {
    return said_about(good_scene, {assignment});
}

inline std::string inputs_folder() {
    return MORAINE_INPUTS;
}

}  // namespace moraine
