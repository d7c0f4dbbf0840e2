#include "comm/activity_exchange.hpp"

namespace moraine {

template <int Dim>
void exchange_activity(PointToPoint& messages, const EpochTables<Dim>& tables, std::vector<double>& activity) {
    std::vector<std::vector<double>> out, in;
    std::vector<Parcel> sends, receives;
    const auto parcel = [](int rank, std::vector<double>& of) {
        const auto bytes = static_cast<std::int64_t>(of.size() * sizeof(double));
        return Parcel{rank, reinterpret_cast<std::byte*>(of.data()), bytes, bytes};
    };
    for (const PeerHalo& peer : tables.peers) {
        out.emplace_back();
        for (const std::int32_t b : peer.send.block) out.back().push_back(activity[static_cast<std::size_t>(b)]);
        in.emplace_back(peer.receive.block.size());
        sends.push_back(parcel(peer.rank, out.back()));
        receives.push_back(parcel(peer.rank, in.back()));
    }
    messages.start(sends, receives);
    messages.finish();
    for (std::size_t k = 0; k < in.size(); ++k)
        for (std::size_t t = 0; t < in[k].size(); ++t)
            activity[tables.own.size() + static_cast<std::size_t>(tables.peers[k].receive.block[t])] = in[k][t];
}

template void exchange_activity(PointToPoint&, const EpochTables<2>&, std::vector<double>&);
template void exchange_activity(PointToPoint&, const EpochTables<3>&, std::vector<double>&);

}  // namespace moraine
