#pragma once
// Spreadsheets write a byte order mark (EF BB BF) before text in UTF-8 ("CSV UTF-8"). Nobody sees it in an editor, and
// it is no part of the first word.

#include <string>

namespace moraine {

inline void drop_byte_order_mark(std::string& text) {
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
}

}  // namespace moraine
