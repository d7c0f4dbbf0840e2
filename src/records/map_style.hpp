#pragma once
// How geographic information systems draw the maps: a style of QGIS beside each, which it finds by the file's name.
// Steps of colour end at round numbers (1, 2, 5 of each decade; times in even steps), so that maps can be compared by
// eye.

#include <string>

namespace moraine {

/// NAME.qml of a map whose largest value is `most`.
std::string map_style(const std::string& map, double most);

}  // namespace moraine
