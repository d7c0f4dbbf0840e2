#include "gpu/engine.hpp"

#include <algorithm>
#include <numeric>

#include "gpu/nodes.hpp"
#include "gpu/refresh.hpp"

namespace moraine::gpu {

namespace {

constexpr int refresh_interval = 12;  ///< steps between memory refreshes: 8 to 16 are equally good (benchmarks/gpu_lab)

std::string device_name() {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "Asking for the device");
    check(cudaGetDeviceProperties(&properties, device), "Asking the device for its name");
    return properties.name;
}

template <int Dim>
Ledger<Dim> ledger_of(const Account<Dim>& a) {
    Ledger<Dim> l;
    l.work = a.work;
    l.lost_mass = a.lost_mass;
    for (std::size_t i = 0; i < Dim; ++i) {
        l.impulse[i] = a.impulse[i];
        l.lost_momentum[i] = a.lost_momentum[i];
        l.lost_pull[i] = a.lost_pull[i];
    }
    l.lost_count = static_cast<std::int64_t>(a.lost_count);
    return l;
}

}  // namespace

template <class Real, int Dim>
DeviceEngine<Real, Dim>::DeviceEngine(const Scene& scene, const Method<Host, Real, Dim>& method)
    : scene_(scene),
      method_(method),
      name_(device_name()),
      share_(method.needs, method.stencil.width),
      particles_(method.needs) {
    choose_kernels();
    half_size_.assign(method.context.half_size, scene.bodies.size());
    std::vector<std::uint16_t> materials;
    for (const BodySpec& body : scene.bodies) materials.push_back(static_cast<std::uint16_t>(body.material));
    material_of_.assign(materials);
    accounts_.resize(account_parts);
    empty_accounts(accounts_.data(), stream_);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::choose_kernels() {
    p2g_ = choose_p2g<Real, Dim>(scene_.shape, method_.needs.affine);
    if (fuses(scene_)) {
        gather_ = make_fused_gather<Real, Dim>(scene_.materials.front());
        return;
    }
    gather_ = make_gather<Real, Dim>(scene_.shape, method_.needs.affine);
    for (const MaterialSpec& material : scene_.materials) stress_.push_back(make_stress<Real, Dim>(material));
}

template <class Real, int Dim>
View<Real, Dim> DeviceEngine<Real, Dim>::view() const {
    View<Real, Dim> v{};
    v.table = tables_.view();
    v.list = lists_.view();
    v.grid = {lists_.tile_of(), reinterpret_cast<Real*>(tiles_.data()), node_of_.data(),
              reinterpret_cast<Real*>(nodes_.data())};
    v.p = particles_.view();
    v.context = method_.context;
    v.context.half_size = half_size_.data();
    v.moves = lists_.moves();
    v.changed = lists_.changed();
    v.accounts = accounts_.data();
    return v;
}

template <class Real, int Dim>
Launch DeviceEngine<Real, Dim>::launch() const {
    return {static_cast<int>(std::max<std::int64_t>(1, census_.blocks)), stream_};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::make_tiles(std::size_t tiles) {
    tile_room_ = tiles;
    tiles_.release();
    tiles_.resize((tiles + ghosts_) * static_cast<std::size_t>(2 * power<Dim>(tile_side(method_.stencil.width))));
    lists_.limit_tiles(static_cast<std::uint32_t>(tiles), tables_.view(), stream_);
}

/// What an epoch's tables ask for, once the lists are in place.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::begin_epoch() {
    ghosts_ = epoch_.ghost.size();
    std::vector<std::int32_t> every(epoch_.node_key.size());
    std::iota(every.begin(), every.end(), 0);
    node_of_.assign(every);
    nodes_.resize(every.size() * static_cast<std::size_t>(2 * Block<Dim>::cells));
    const auto blocks = static_cast<std::size_t>(census_.blocks);
    const std::size_t room = std::min(epoch_.own.size(), blocks + blocks / 16 + 16);
    if (room > tile_room_ || 2 * room < tile_room_) make_tiles(room);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::adopt(EpochTables<Dim> tables, const FiledBlocks& filed) {
    stream_.wait();
    share_.install(std::move(tables), filed);
    epoch_ = share_.tables();
    tables_.upload(epoch_);
    const std::uint32_t* bounds = share_.list().cell_first;
    lists_.install(epoch_, tables_.view(), filed, {bounds, bounds + epoch_.own.size() * Lists<Dim>::bounds});
    particles_.upload(share_.particles.columns(), filed.slot);
    census_ = {static_cast<std::int64_t>(filed.slot.size()), static_cast<std::int64_t>(filed.key.size())};
    gradient_.resize(stress_.empty() ? 0 : filed.slot.size() * Dim * Dim);
    begin_epoch();
    steps_since_refresh_ = 0;
    share_is_of_now_ = true;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::renew(EpochTables<Dim> tables) {
    stream_.wait();
    const std::vector<Key> old = std::move(epoch_.own);
    epoch_ = std::move(tables);
    tables_.upload(epoch_);
    lists_.renew(epoch_, tables_.view(), old, lists_.first());
    begin_epoch();
    share_is_of_now_ = false;
}

template <class Real, int Dim>
Patch<Host, Real, Dim>& DeviceEngine<Real, Dim>::share() {
    if (share_is_of_now_) return share_;
    stream_.wait();
    const std::vector<std::uint32_t> first = lists_.first();
    FiledBlocks filed;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        filed.key.push_back(epoch_.own[b]);
        filed.count.push_back(first[b + 1] - first[b]);
    }
    filed.slot = share_.start_over(first.back());
    particles_.download(share_.particles.columns(), lists_.slots(), first.back());
    share_.install(epoch_, filed);
    share_is_of_now_ = true;
    return share_;
}

template <class Real, int Dim>
BlockCounts DeviceEngine<Real, Dim>::block_counts(bool with_cells) {
    stream_.wait();
    const std::vector<std::uint32_t> first = lists_.first();
    const std::vector<std::uint32_t> cells = with_cells ? lists_.cell_first() : std::vector<std::uint32_t>{};
    BlockCounts counts;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        counts.key.push_back(epoch_.own[b]);
        counts.count.push_back(first[b + 1] - first[b]);
        const auto bounds = cells.begin() + static_cast<std::ptrdiff_t>(with_cells ? b * Lists<Dim>::bounds : 0);
        std::int64_t occupied = 0;
        for (int c = 0; with_cells && c < Block<Dim>::cells; ++c) occupied += bounds[c + 1] > bounds[c];
        if (with_cells) counts.cells.push_back(occupied);
    }
    return counts;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::file() {
    if (!moving_) return;
    lists_.file(tables_.view(), stream_);
    fold_report(accounts_.data(), lists_.particles(), lists_.occupied(), report_.device(), stream_);
    reported_.record(stream_);
    moving_ = false;
}

/// Boundary and interior at once: the device has its queue.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_boundary() {
    watch_.start(stream_);
    sum();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum() {
    for (const Chosen& chosen : {lists_.boundary(), lists_.interior()})
        p2g_(view(), chosen, p2g_grid<Dim>(launch().blocks), method_.cell, stream_);
    watch_.mark(1, stream_);
    share_is_of_now_ = false;
    summed_ = true;
}

/// The flow occupies more blocks than there were tiles for: the lists were told to be empty meanwhile.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::grow_tiles() {
    stream_.wait();
    make_tiles(static_cast<std::size_t>(census_.blocks + census_.blocks / 8));
    if (summed_) sum();
}

/// Memory into list order. Between P2G and the gather it disturbs nobody.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::refresh() {
    const auto n = static_cast<std::size_t>(census_.particles);
    particles_.refresh(lists_.slots(), n, stream_);
    count_up(static_cast<std::uint32_t>(n), lists_.slots(), stream_);
    steps_since_refresh_ = 0;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::solve_nodes(const Round& round, const StepScales<Dim>& step) {
    const NodeRound<Real, Dim> args{round.nodes, static_cast<Real>(step.dt), method_.gravity, method_.damping,
                                    static_cast<Real>(step.mass_cutoff)};
    gpu::solve_nodes(view(), method_.stencil, args, step.quantum, stream_);
    watch_.mark(2, stream_);
    summed_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::gather(const Round& round, const StepScales<Dim>& step) {
    const auto stride = static_cast<std::uint64_t>(particles_.size());
    GatherArgs<Real, Dim> args{};
    args.ends = method_.ends;
    args.gather = round.gather;
    args.tpic = method_.tpic;
    args.flip = method_.flip;
    args.dt = static_cast<Real>(step.dt);
    std::copy(step.pull.begin(), step.pull.end(), args.pull);
    args.quantum = step.quantum;
    args.gradient = gradient_.data();
    args.gradient_stride = stride;
    StressArgs<Real, Dim> stress{
        args.dt, step.quantum, gradient_.data(), stride, stress_.size() > 1 ? material_of_.data() : nullptr, 0};
    for (const Chosen& chosen : {lists_.boundary(), lists_.interior()}) {
        gather_->run(view(), chosen, args, launch());
        if (!(round.gather & gather_gradient)) continue;
        for (stress.mine = 0; stress.mine < static_cast<int>(stress_.size()); ++stress.mine)
            stress_[static_cast<std::size_t>(stress.mine)]->run(view(), chosen, stress, launch());
    }
    watch_.mark(3, stream_);
}

template <class Real, int Dim>
std::vector<Offence<Dim>> DeviceEngine<Real, Dim>::offences() {
    if (!faults_) return {};
    const Share& here = share();
    const ListView<Dim> list = here.list();
    const ParticleView<Real, Dim> p = share_.particles.view();
    for (int b = 0; b < here.own(); ++b)
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k)
            if (p.id[list.slot[k]] == offender_)
                return {
                    {offender_, faults_,
                     place_in<Real, Dim>(scene_, method_.stencil, here.table().position[b], p.position[list.slot[k]])}};
    return {{offender_, faults_, {}}};
}

template <class Real, int Dim>
StepReport<Dim> DeviceEngine<Real, Dim>::take_report() {
    reported_.wait();
    const Account<Dim>& account = report_->account;
    census_ = {report_->particles, report_->occupied()};
    faults_ = account.faults;
    offender_ = account.offender;
    StepReport<Dim> report;
    report.signal = std::bit_cast<double>(account.signal);
    report.moved = std::bit_cast<double>(account.moved);
    report.faults = account.faults;
    report.clamped = account.clamped;
    report.ledger = ledger_of(account);
    report.seconds = watch_.take();
    if (report_->occupied() > tile_room_) grow_tiles();
    if (++steps_since_refresh_ >= refresh_interval) refresh();
    return report;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
