#pragma once
// The one door for numbers out of files that a scene names: text grids, tables and areas word by word, rasters by
// value.
//
// What is unknown is NaN behind it, in every form that a format has: the value that the file declares, in double
// precision or rounded to single; NaN; and beyond 1e30 the numbers that programs write without a word (the lowest
// single -3.4e38, netCDF's 9.97e36): no height, depth or coefficient is so large.

#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace moraine {

/// "x.CSV" ends as ".csv".
bool has_ending(const std::string& path, std::string_view ending);

std::string lower_case(std::string_view word);

/// A decimal number with a point, of either sign. None: it is none, or there is more.
std::optional<double> number_in(std::string_view word);

/// Whether a raw number from a file is one that is not known.
bool is_no_data(double raw, std::optional<double> declared);

/// The first `most` bytes of a regular file, without a byte order mark. `kind` and `key` are for messages.
std::string text_of(const std::string& path, const std::string& kind, const std::string& key,
                    std::streamoff most = std::numeric_limits<std::streamoff>::max());

/// Words of a text and the line on which each stands. `text` must outlive it.
class Words {
  public:
    Words(const std::string& text, std::string path, std::string_view between, int line = 1)
        : text_(text), path_(std::move(path)), between_(between), line_(line) {}

    /// Without the quotes around it.
    std::optional<std::string_view> next();
    std::string place() const;
    std::size_t bytes_left() const { return text_.size() - at_; }

    /// A finite number. Throws InputError.
    double number(std::string_view word, const std::string& what) const;

  private:
    const std::string& text_;
    std::string path_;
    std::string_view between_;
    std::size_t at_ = 0;
    int line_;
};

}  // namespace moraine
