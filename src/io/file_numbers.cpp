#include "io/file_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "io/byte_order_mark.hpp"
#include "io/input_error.hpp"

namespace moraine {

std::string lower_case(std::string_view word) {
    std::string text(word);
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

bool has_ending(const std::string& path, std::string_view ending) {
    return path.size() >= ending.size() && lower_case(path.substr(path.size() - ending.size())) == ending;
}

std::optional<double> number_in(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    double value = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size()) return std::nullopt;
    return value;
}

bool is_no_data(double raw, std::optional<double> declared) {
    if (std::isnan(raw) || (std::isfinite(raw) && std::fabs(raw) >= 1e30)) return true;
    return declared && (raw == *declared || static_cast<float>(raw) == static_cast<float>(*declared));
}

std::string text_of(const std::string& path, const std::string& kind, const std::string& key, std::streamoff most) {
    std::error_code none;
    const std::string problem = fmt::format("the {} cannot be read", kind), remedy = fmt::format("Is {} right?", key);
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
        refuse(path, problem, "it is not a regular file", remedy);
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) refuse(path, problem, "no such file or no permission", remedy);
    std::string text(static_cast<std::size_t>(std::min<std::streamoff>(file.tellg(), most)), '\0');
    file.seekg(0);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    drop_byte_order_mark(text);
    return text;
}

std::optional<std::string_view> Words::next() {
    const auto separates = [&](char c) { return between_.find(c) != std::string_view::npos; };
    while (at_ < text_.size() && separates(text_[at_]))
        if (text_[at_++] == '\n') ++line_;
    if (at_ == text_.size()) return std::nullopt;
    const std::size_t first = at_;
    while (at_ < text_.size() && !separates(text_[at_])) ++at_;
    std::string_view word = std::string_view(text_).substr(first, at_ - first);
    if (word.size() > 2 && word.front() == '"' && word.back() == '"') word = word.substr(1, word.size() - 2);
    return word;
}

std::string Words::place() const {
    return fmt::format("{}:{}", path_, line_);
}

double Words::number(std::string_view word, const std::string& what) const {
    const std::optional<double> value = number_in(word);
    if (!value || !std::isfinite(*value))
        refuse(place(), fmt::format("{} = {}", what, quote(std::string(word.substr(0, 40)))), "must be a finite number",
               word.find('\0') != std::string_view::npos ? "It holds zero bytes: is the file whole?"
                                                         : "Is the decimal sign a point?");
    return *value;
}

}  // namespace moraine
