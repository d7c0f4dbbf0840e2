#include "replay/flow_speed.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

namespace moraine {
namespace {

std::vector<std::string> split_row(const std::string& line) {
    std::vector<std::string> words(1);
    for (const char c : line)
        if (c == ',')
            words.emplace_back();
        else
            words.back() += c;
    return words;
}

double number_of(std::string_view text) {
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return std::isfinite(value) ? value : 0;
}

/// domain.cell [m] of the keys in scene.json, where it is text.
double cell_of(const std::string& path) {
    std::ifstream file(path);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const std::string name = "\"domain.cell\": \"";
    const std::size_t at = text.find(name);
    return at == std::string::npos ? 0 : number_of(std::string_view(text).substr(at + name.size(), 32));
}

}  // namespace

double cells_per_step(const std::string& directory) {
    const double cell = cell_of(directory + "/scene.json");
    std::ifstream file(directory + "/history.csv");
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = split_row(line);
    const auto column = [&](const char* name) { return std::find(names.begin(), names.end(), name) - names.begin(); };
    const auto dt = static_cast<std::size_t>(column("dt_s")), speed = static_cast<std::size_t>(column("max_speed_m_s"));
    if (!(cell > 0) || dt == names.size() || speed == names.size()) return 0;
    double sum = 0;
    std::int64_t rows = 0;
    while (std::getline(file, line)) {
        const std::vector<std::string> parts = split_row(line);
        if (parts.size() != names.size() || number_of(parts[dt]) <= 0) continue;  // no step yet
        sum += number_of(parts[dt]) * number_of(parts[speed]) / cell;
        ++rows;
    }
    return rows > 0 ? sum / static_cast<double>(rows) : 0;
}

}  // namespace moraine
