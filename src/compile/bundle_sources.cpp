// Made by the build, run by it: writes the headers that are compiled at run time into one file (source_bundle.hpp).
//
//   bundle_sources OUTPUT DEPFILE ROOT... -- DIRECTORY...
//
// Follows every #include of the roots through the directories, in order; what is in none of them is left out, because
// a preprocessor branch of the host may name it. DEPFILE: for the build, in make's form.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Bundle {
    std::vector<fs::path> directories;
    std::set<std::string> seen;
    std::vector<std::string> files;  ///< as opened
    std::string content;

    /// The name in an #include line, or nothing.
    static std::string included(const std::string& line) {
        const std::size_t hash = line.find_first_not_of(" \t");
        if (hash == std::string::npos || line[hash] != '#') return {};
        const std::size_t word = line.find_first_not_of(" \t", hash + 1);
        if (word == std::string::npos || line.compare(word, 7, "include") != 0) return {};
        const std::size_t open = line.find_first_of("<\"", word);
        if (open == std::string::npos) return {};
        const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
        return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
    }

    void add(const std::string& name) {
        if (!seen.insert(name).second) return;
        for (const fs::path& directory : directories) {
            const fs::path path = directory / name;
            if (!fs::is_regular_file(path)) continue;
            std::ifstream in(path, std::ios::binary);
            const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
            files.push_back(path.string());
            content += name + '\0' + text + '\0';
            std::size_t at = 0;
            while (at < text.size()) {
                const std::size_t end = std::min(text.find('\n', at), text.size());
                const std::string next = included(text.substr(at, end - at));
                if (!next.empty()) add(next);
                at = end + 1;
            }
            return;
        }
    }
};

}  // namespace

int main(int count, char** words) {
    Bundle bundle;
    std::vector<std::string> roots;
    bool of_directories = false;
    for (int i = 3; i < count; ++i) {
        const std::string word = words[i];
        if (word == "--")
            of_directories = true;
        else if (of_directories)
            bundle.directories.emplace_back(word);
        else
            roots.push_back(word);
    }
    for (const std::string& root : roots) {
        bundle.add(root);
        if (bundle.files.empty()) return std::cerr << "bundle_sources: no " << root << '\n', 1;
    }
    std::ofstream(words[1], std::ios::binary) << bundle.content;
    std::ofstream depfile(words[2]);
    depfile << words[1] << ':';
    for (const std::string& file : bundle.files) depfile << " \\\n " << file;
    depfile << '\n';
    return depfile.good() ? 0 : 1;
}
