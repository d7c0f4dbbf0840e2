#include "io/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "core/data/error.hpp"

namespace moraine {

const std::string& Places::of(std::string path) const {
    for (;;) {
        if (const auto found = places_.find(path); found != places_.end()) return found->second;
        const std::size_t dot = path.rfind('.');
        if (dot == std::string::npos) return file_;
        path.resize(dot);
    }
}

namespace {

bool is_inside_character(char c) {
    return (static_cast<unsigned char>(c) & 0xc0) == 0x80;  // UTF-8
}

/// Beginning and end of a text of more than `most` bytes.
std::string cut(const std::string& text, std::size_t most) {
    if (text.size() <= most) return text;
    std::size_t first = most / 2, second = text.size() - (most / 2 - 5);
    while (first > 0 && is_inside_character(text[first])) --first;
    while (second < text.size() && is_inside_character(text[second])) ++second;
    return text.substr(0, first) + " ... " + text.substr(second);
}

/// 0x80 to 0x9f, which terminals obey as well, are two bytes of UTF-8.
bool is_second_control(const std::string& text, std::size_t at) {
    return at > 0 && static_cast<unsigned char>(text[at - 1]) == 0xc2 && static_cast<unsigned char>(text[at]) < 0xa0 &&
           is_inside_character(text[at]);
}

}  // namespace

std::string printable(const std::string& text, std::size_t most) {
    std::string out;
    for (std::size_t k = 0; k < text.size(); ++k) {
        const auto c = static_cast<unsigned char>(text[k]);
        const bool second = is_second_control(text, k);
        if (second) out.pop_back();
        if (c < 0x20 || c == 0x7f || second)
            out += fmt::format("\\u{:04x}", static_cast<int>(c));
        else
            out += text[k];
    }
    return cut(out, most);
}

void refuse(const std::string& place, const std::string& problem, const std::string& why,
            const std::string& suggestion) {
    constexpr std::size_t most = 500;
    throw InputError(fmt::format("{}: {} ({}). {}", printable(place, most), printable(problem, most),
                                 printable(why, most), printable(suggestion, 2 * most)));  // valid names
}

int edit_distance(const std::string& a, const std::string& b) {
    const std::size_t columns = b.size() + 1;
    std::vector<int> table((a.size() + 1) * columns);
    const auto at = [&](std::size_t i, std::size_t j) -> int& { return table[i * columns + j]; };
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                at(i, j) = static_cast<int>(i + j);
                continue;
            }
            const int substitution = at(i - 1, j - 1) + (a[i - 1] == b[j - 1] ? 0 : 1);
            at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, substitution});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
        }
    return at(a.size(), b.size());
}

std::string nearest(const std::string& word, std::span<const std::string> candidates) {
    std::string best;
    if (word.size() > longest_guess) return best;
    int least = std::max(2, static_cast<int>(word.size()) / 2);
    for (const std::string& candidate : candidates) {
        const bool starts = word.size() > 2 && candidate.starts_with(word);
        const int distance = starts ? 1 : edit_distance(word, candidate);
        if (distance < least || (distance == least && best.empty() && distance < static_cast<int>(word.size()))) {
            least = distance;
            best = candidate;
        }
    }
    return best;
}

std::string suggest(const std::string& word, std::span<const std::string> candidates) {
    const std::string near = nearest(word, candidates);
    if (!near.empty()) return fmt::format("Did you mean {}?", near);
    return fmt::format("Use {}{}?", candidates.size() > 1 ? "one of " : "", listed(candidates));
}

std::string listed(std::span<const std::string> words) {
    return fmt::format("{}", fmt::join(words, ", "));
}

std::string quote(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 0x20)
            out += fmt::format("\\u{:04x}", static_cast<int>(c));
        else
            out += c;
    }
    return out + '"';
}

std::string shortest(double x) {
    return fmt::format("{}", x);
}

}  // namespace moraine
