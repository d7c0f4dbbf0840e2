#pragma once
// Words for wrong input: where it stands, `problem (why). suggestion?`, and the nearest valid name.
//
// A line is named as FILE:LINE, and a value that came from the command line as --set KEY=VALUE.

#include <map>
#include <span>
#include <string>
#include <vector>

namespace moraine {

/// Where each key and table of a scene was written: "body.clay.radius" -> "scene.toml:12".
class Places {
  public:
    explicit Places(std::string file) : file_(std::move(file)) {}

    void add(const std::string& path, std::string place) { places_[path] = std::move(place); }
    bool has(const std::string& path) const { return places_.contains(path); }
    /// Of the path, else of the innermost table around it that was written, else the file.
    const std::string& of(std::string path) const;

  private:
    std::string file_;
    std::map<std::string, std::string> places_;
};

/// Words longer than this are not compared with valid names: nobody meant one, and it would take long.
constexpr std::size_t longest_guess = 64;

/// As a message may show it: control characters escaped, which names and values may bring to a terminal, and more than
/// `most` bytes cut in the middle.
std::string printable(const std::string& text, std::size_t most);

/// Throws InputError "place: problem (why). suggestion", each part printable.
[[noreturn]] void refuse(const std::string& place, const std::string& problem, const std::string& why,
                         const std::string& suggestion);

/// Insertions, deletions, substitutions and swaps of neighbours that turn a into b.
int edit_distance(const std::string& a, const std::string& b);

/// The candidate that was probably meant; empty when none is near.
std::string nearest(const std::string& word, std::span<const std::string> candidates);

/// "Did you mean NEAREST?", or "Use one of A, B, C?" when none is near.
std::string suggest(const std::string& word, std::span<const std::string> candidates);

/// "A, B, C"
std::string listed(std::span<const std::string> words);

/// "a \"b\"" as TOML writes it.
std::string quote(const std::string& text);

/// The shortest decimal number that reads back as x.
std::string shortest(double x);

}  // namespace moraine
