#include "io/block_loads.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <filesystem>

#include "core/data/error.hpp"
#include "core/data/hash.hpp"

namespace moraine {
namespace {

struct FrameHead {
    std::array<char, 8> magic{'i', 'n', 't', 'e', 'r', 'v', 'a', 'l'};
    std::int64_t step;
    double time;
    double lost;
    std::int64_t exchanges;
    std::int64_t ranks;
    std::int64_t blocks;
    std::uint64_t hash;  ///< of all before it and of what follows
};
static_assert(sizeof(FrameHead) == 64);

std::uint64_t hash_of(const LoadHeader& header) {
    return mix_bytes(0, reinterpret_cast<const std::byte*>(&header), offsetof(LoadHeader, hash));
}

std::uint64_t hash_of(const FrameHead& head, const LoadFrame& frame) {
    std::uint64_t h = mix_bytes(0, reinterpret_cast<const std::byte*>(&head), offsetof(FrameHead, hash));
    const auto seconds = std::as_bytes(std::span(frame.seconds));
    const auto rows = std::as_bytes(std::span(frame.rows));
    h = mix_bytes(h, seconds.data(), seconds.size());
    return mix_bytes(h, rows.data(), rows.size());
}

std::vector<std::byte> bytes_of(const LoadFrame& frame) {
    FrameHead head{{'i', 'n', 't', 'e', 'r', 'v', 'a', 'l'},
                   frame.step,
                   frame.time,
                   frame.lost,
                   frame.exchanges,
                   static_cast<std::int64_t>(frame.seconds.size()),
                   static_cast<std::int64_t>(frame.rows.size()),
                   0};
    head.hash = hash_of(head, frame);
    std::vector<std::byte> bytes;
    const auto add = [&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); };
    bytes.reserve(sizeof head + frame.seconds.size() * sizeof(RankSeconds) + frame.rows.size() * sizeof(LoadRow));
    add(std::as_bytes(std::span(&head, 1)));
    add(std::as_bytes(std::span(frame.seconds)));
    add(std::as_bytes(std::span(frame.rows)));
    return bytes;
}

bool same_domain(const LoadHeader& a, const LoadHeader& b) {
    return a.magic == b.magic && a.dimensions == b.dimensions && a.width == b.width && a.blocks == b.blocks &&
           a.periodic == b.periodic && a.block_side == b.block_side;
}

}  // namespace

BlockLoadWriter::BlockLoadWriter(const Comm& comm, std::string path, const LoadHeader& header,
                                 std::optional<std::int64_t> resume_step)
    : comm_(comm), path_(std::move(path)) {
    const bool resumes = comm.is_root() && resume_step && std::filesystem::exists(path_);
    end_ = sizeof header;
    comm.agree_no_error<InputError>(message_of([&] {
        if (resumes) take_over(header, *resume_step);
    }));
    comm.agree_no_error<MachineError>(message_of([&] {
        if (!comm.is_root()) return;
        std::error_code failed;
        if (resumes) std::filesystem::resize_file(path_, static_cast<std::uintmax_t>(end_), failed);
        if (failed)
            throw MachineError(fmt::format("cannot shorten {} ({}). Is it read-only?", path_, failed.message()));
        file_ = std::make_unique<DiskFile>(path_, resumes ? DiskFile::Mode::append : DiskFile::Mode::create);
        LoadHeader sealed = header;
        sealed.hash = hash_of(header);
        file_->write(std::as_bytes(std::span(&sealed, 1)), 0);
    }));
}

void BlockLoadWriter::take_over(const LoadHeader& header, std::int64_t resume_step) {
    BlockLoadReader there(path_);
    if (!same_domain(there.header(), header))
        throw InputError(fmt::format("cannot continue {} (it is of another domain). Another --output?", path_));
    if (there.header().sleepers != header.sleepers)
        throw InputError(
            fmt::format("cannot continue {} (it says otherwise who sleeps: numerics.sleep or output.block_loads is not "
                        "that of its run). Another --output?",
                        path_));
    LoadFrame frame;
    try {
        while (there.next(frame) && frame.step <= resume_step) end_ = there.position(), last_step_ = frame.step;
    } catch (const InputError&) {
        // What a killed run left torn lies after the checkpoint, or is lost: the whole frames stay.
    }
}

void BlockLoadWriter::write(const LoadFrame& frame) {
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (!comm_.is_root() || frame.step <= last_step_) return;
        const std::vector<std::byte> bytes = bytes_of(frame);
        file_->write(bytes, end_);
        end_ += static_cast<std::int64_t>(bytes.size());
        last_step_ = frame.step;
    }));
}

BlockLoadReader::BlockLoadReader(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "rb")) {
    if (!file_) throw InputError(fmt::format("cannot read {} ({}). Is the path right?", path, std::strerror(errno)));
    std::error_code none;
    size_ = static_cast<std::int64_t>(std::filesystem::file_size(path, none));
    if (std::fread(&header_, 1, sizeof header_, file_.get()) != sizeof header_)
        refuse(fmt::format("it has {} bytes, its header alone {}", size_, sizeof header_));
    if (header_.magic != LoadHeader{}.magic) refuse("it does not begin as a record of block loads of this version");
    if (hash_of(header_) != header_.hash || header_.partitioner.back() != '\0')
        refuse("the bytes of its header are not those that were written");
    position_ = sizeof header_;
}

void BlockLoadReader::refuse(const std::string& why) const {
    const std::string help = last_step_ < 0 ? "Record the run again with --set output.block_loads=on?"
                                            : fmt::format("Use what is whole, --last-step {}?", last_step_);
    throw InputError(fmt::format("{} is truncated or damaged ({}). {}", path_, why, help));
}

bool BlockLoadReader::next(LoadFrame& frame) {
    if (position_ == size_) return false;
    FrameHead head{};
    if (std::fread(&head, 1, sizeof head, file_.get()) != sizeof head) refuse("its last interval is cut off");
    const std::int64_t left = size_ - position_ - static_cast<std::int64_t>(sizeof head);
    if (head.magic != FrameHead{}.magic || head.ranks < 0 || head.blocks < 0 || head.step <= last_step_)
        refuse(fmt::format("no interval begins at byte {}", position_));
    if (head.ranks > left / static_cast<std::int64_t>(sizeof(RankSeconds)) ||
        head.blocks > (left - head.ranks * static_cast<std::int64_t>(sizeof(RankSeconds))) /
                          static_cast<std::int64_t>(sizeof(LoadRow)))
        refuse(fmt::format("the interval of step {} is cut off", head.step));
    frame.step = head.step;
    frame.time = head.time;
    frame.lost = head.lost;
    frame.exchanges = head.exchanges;
    frame.seconds.resize(static_cast<std::size_t>(head.ranks));
    frame.rows.resize(static_cast<std::size_t>(head.blocks));
    const bool whole =
        std::fread(frame.seconds.data(), sizeof(RankSeconds), frame.seconds.size(), file_.get()) ==
            frame.seconds.size() &&
        std::fread(frame.rows.data(), sizeof(LoadRow), frame.rows.size(), file_.get()) == frame.rows.size();
    if (!whole || hash_of(head, frame) != head.hash)
        refuse(fmt::format("the bytes of step {} are not those that were written", head.step));
    position_ += static_cast<std::int64_t>(sizeof head + frame.seconds.size() * sizeof(RankSeconds) +
                                           frame.rows.size() * sizeof(LoadRow));
    last_step_ = frame.step;
    return true;
}

}  // namespace moraine
