#include "comm/timeline.hpp"

#include <algorithm>

namespace moraine {

Timeline::Timeline(std::size_t capacity) : capacity_(std::max<std::size_t>(16, capacity)) {
    spans_.reserve(capacity_);
    start();
}

void Timeline::add(const SpanName& name, int phase, SteadyTime begin, SteadyTime end) {
    using std::chrono::nanoseconds;
    const Span span{name, phase, nanoseconds(begin - start_).count(), nanoseconds(end - begin).count(), step_};
    if (!is_kept(span)) return;
    constexpr std::int64_t longest = std::int64_t(1) << 40;  // then only rare ones are left
    while (spans_.size() >= capacity_ && stride_ < longest) thin(2 * stride_);
    if (spans_.size() >= capacity_)
        ++lost_;
    else if (is_kept(span))
        spans_.push_back(span);
}

void Timeline::thin(std::int64_t stride) {
    stride_ = std::max(stride_, stride);
    std::erase_if(spans_, [&](const Span& span) { return !is_kept(span); });
}

const std::vector<Span>& Timeline::sorted() {
    std::stable_sort(spans_.begin(), spans_.end(), [](const Span& a, const Span& b) {
        return a.begin != b.begin ? a.begin < b.begin : a.length > b.length;
    });
    return spans_;
}

}  // namespace moraine
