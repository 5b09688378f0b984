// An independent simulator of the data-set format amb-dataset/1.
//
// Written from the sentences of the format and of the catalogue of effects alone. It includes no header of
// this project, shares no code with it and none of its methods: one fixed-step Runge-Kutta scheme of fourth
// order between the instants at which something switches, the settled state by running in from rest, every
// force written out.
//
// Frame: inertial, z along the shaft, x horizontal, y up; x(z) = x_G + z beta, y(z) = y_G - z alpha.
// Positions are relative to the stator. SI units. A parameter that is not set stands for "no such effect".
// What the two readings of a sentence are is said where one of them was taken.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <vector>

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSlipSpeed = 0.01;  // [m/s] of tanh(v/0.01 m/s)

#define PARAMETERS(P)                                                                                        \
  P(mass)                                                                                                    \
  P(transverse_inertia) P(polar_inertia) P(gravity) P(z_amb_a) P(z_amb_b) P(z_sensor_a) P(z_sensor_b) P(     \
      z_aux_a) P(z_aux_b) P(equivalent) P(equivalent_k) P(equivalent_d) P(ki_force) P(ks) P(bias_current)    \
      P(bias_flux) P(amplifier_hz) P(max_current) P(control_hz) P(kp) P(kd) P(ki) P(filter_hz) P(delay)      \
          P(integral_settled) P(clearance) P(radius) P(contact_k) P(contact_d) P(friction) P(bow_a) P(bow_b) \
              P(bow_phase) P(runout_a1) P(runout_a1_phase) P(runout_a2) P(runout_a2_phase) P(runout_b1)      \
                  P(runout_b1_phase) P(runout_b2) P(runout_b2_phase) P(gain_ax) P(gain_ay) P(gain_bx)        \
                      P(gain_by) P(angle_a) P(angle_b) P(load_x) P(load_y) P(anisotropy) P(cross_q)          \
                          P(cross_hz) P(cross_exponent) P(cross_z) P(internal_d) P(internal_z) P(foundation) \
                              P(foundation_mass) P(foundation_hz) P(foundation_ratio) P(nonlinear)           \
                                  P(nonlinear_i0) P(nonlinear_s0) P(saturating) P(knee) P(eddy) P(eddy_hz)   \
                                      P(pull_k) P(pull_z) P(offset_ax) P(offset_ay) P(offset_bx)             \
                                          P(offset_by) P(hertz) P(hertz_k) P(hertz_l) P(mount) P(mount_k)    \
                                              P(mount_d) P(mount_mass) P(stribeck) P(mu_static)              \
                                                  P(mu_dynamic) P(stribeck_speed) P(ring) P(ring_inertia)    \
                                                      P(ring_drag) P(crack_depth) P(crack_phase) P(flexible) \
                                                          P(flex_hz) P(flex_ratio) P(shape_amb_a)            \
                                                              P(shape_amb_b) P(shape_sensor_a)               \
                                                                  P(shape_sensor_b) P(shape_aux_a)           \
                                                                      P(shape_aux_b) P(law_quadratic) P(law_cubic) \
                                                                          P(law_third) P(law_third_phase) P(law_dry) \
  P(law_z_m) P(law_plane_quadratic) P(law_plane_cubic) P(law_plane_speed) P(law_plane_third)                 \
      P(law_plane_third_phase) P(law_tilt_cubic) P(law_tilt_drag) P(law_swirl) P(law_current) \
  P(law_sensor_play) P(law_sensor_cubic) P(law_sensor_limit) P(law_sensor_speed)

struct Parameters {
#define P(name) double name;
  PARAMETERS(P)
#undef P
};

// Indices of the state: positions, then velocities, then the spins of the two inner rings.
enum { XG, YG, AL, BE, QX, QY, FX, FY, MAX_, MAY, MBX, MBY, NPOS, VEL = NPOS, RA = 2 * NPOS, RB, NSTATE };
using State = std::array<double, NSTATE>;

struct Unbalance {
  double z, moment, phase, shape;
};

// Speed linear in time between knots [s, rad/s]; constant before the first and after the last. The angle is
// exact.
struct Spin {
  std::vector<double> t, w, angle;
  void at(double time, double& theta, double& speed, double& slope) const {
    if (time <= t.front() || t.size() == 1) {
      theta = angle.front() + w.front() * (time - t.front()), speed = w.front(), slope = 0;
      return;
    }
    std::size_t i = std::upper_bound(t.begin(), t.end(), time) - t.begin();
    if (i >= t.size()) i = t.size() - 1;
    const double s = (w[i] - w[i - 1]) / (t[i] - t[i - 1]), dt = time - t[i - 1];
    theta = angle[i - 1] + w[i - 1] * dt + 0.5 * s * dt * dt, speed = w[i - 1] + s * dt, slope = s;
  }
};

// 1/(1 + sqrt(s/w)) = integral of m(u) u w/(s + u w) du/u with m = sqrt(u)/(pi (1 + u)): poles on the
// negative real axis, evenly spaced in ln u. The trapezoidal rule converges geometrically; 0.5 leaves 1e-8,
// the cut tails 1e-4, which go to the fastest pole (above) and the slowest (below).
struct Eddy {
  std::vector<double> rate, weight;
  std::array<std::vector<double>, 4> state;
  explicit Eddy(double corner) {
    const double step = 0.5;
    for (double x = -17; x <= 17.001; x += step) {
      rate.push_back(corner * std::exp(x));
      weight.push_back(step * std::exp(x / 2) / (kPi * (1 + std::exp(x))));
    }
    double sum = 0;
    for (double c : weight) sum += c;
    weight.front() += 0.5 * (1 - sum), weight.back() += 0.5 * (1 - sum);
    for (auto& s : state) s.assign(rate.size(), 0.0);
  }
  // Exact for an input that is linear from i0 to i1 within h. Slow poles are hurried in the run-in.
  double advance(int axis, double i0, double i1, double h, double slowest) {
    if (h != h_ || slowest != slowest_) {
      h_ = h, slowest_ = slowest;
      left_.clear(), mean_.clear();
      for (double r : rate) {
        const double l = std::max(r, slowest);
        left_.push_back(std::exp(-l * h)), mean_.push_back(-std::expm1(-l * h) / (l * h));
      }
    }
    double out = 0;
    for (std::size_t k = 0; k < rate.size(); ++k) {
      double& v = state[axis][k];
      v = i1 + (v - i0) * left_[k] - (i1 - i0) * mean_[k];
      out += weight[k] * v;
    }
    return out;
  }
  double h_ = -1, slowest_ = -1;
  std::vector<double> left_, mean_;
};

struct Machine {
  Parameters p;
  std::vector<Unbalance> unbalance;
  Spin spin;
  double k;        // net bearing stiffness, of the force of a bow or a crack
  bool on = true;  // the bearings give force
  bool laws_apart = false;  // one of those of addLawsApart is set
  bool laws_of_sensors = false;  // one of those of sensorLaws is set

  struct Plane {
    double z, shape;
  };

  void derivative(double t, const State& s, const std::array<double, 4>& current, State& d) const {
    double theta, w, slope;
    spin.at(t, theta, w, slope);
    double fx = p.load_x, fy = p.load_y - p.mass * p.gravity, ma = 0, mb = 0, qx = 0, qy = 0, rx = 0, ry = 0;
    const auto push = [&](double z, double shape, double x, double y) {
      fx += x, fy += y, ma -= z * y, mb += z * x, qx += shape * x, qy += shape * y;
    };
    const auto bearing_push = [&](double z, double shape, double x, double y) {
      push(z, shape, x, y), rx -= x, ry -= y;
    };
    struct Motion {
      double x, y, vx, vy;
    };
    const auto motion = [&](double z, double shape) {
      const double* v = &s[VEL];
      return Motion{s[XG] + z * s[BE] + shape * s[QX] - s[FX], s[YG] - z * s[AL] + shape * s[QY] - s[FY],
                    v[XG] + z * v[BE] + shape * v[QX] - v[FX], v[YG] - z * v[AL] + shape * v[QY] - v[FY]};
    };
    // Unbalance: minus the mass times the acceleration of e exp(j angle).
    for (const Unbalance& u : unbalance) {
      const double c = std::cos(theta + u.phase), n = std::sin(theta + u.phase);
      push(u.z, u.shape, u.moment * (w * w * c + slope * n), u.moment * (w * w * n - slope * c));
    }
    // Bearings.
    for (int b = 0; b < 2 && on; ++b) {
      const double z = b ? p.z_amb_b : p.z_amb_a, shape = b ? p.shape_amb_b : p.shape_amb_a;
      const Motion m = motion(z, shape);
      double force[2];
      for (int axis = 0; axis < 2; ++axis) {
        const double x = axis ? m.y : m.x, v = axis ? m.vy : m.vx, i = current[2 * b + axis];
        double& f = force[axis];
        if (p.equivalent) {
          f = -p.equivalent_k * x - p.equivalent_d * v;
        } else if (p.nonlinear) {
          const double i0 = p.nonlinear_i0, s0 = p.nonlinear_s0;
          const double plus = (1 + i / i0) / (1 - x / s0), minus = (1 - i / i0) / (1 + x / s0);
          f = p.ki_force * i0 / 4 * (plus * plus - minus * minus);
        } else if (p.saturating) {
          const double i0 = p.bias_current, r = i / i0 + p.ks * x / (p.ki_force * i0),
                       bk = p.knee / p.bias_flux;
          const auto soft = [bk](double q) { return q / std::pow(1 + std::pow(q / bk, 4), 0.25); };
          const double plus = soft(1 + r), minus = soft(1 - r);
          f = p.ki_force * i0 / 4 * (plus * plus - minus * minus);
        } else {
          f = p.ki_force * i + p.ks * x;
        }
      }
      const double bow = k * (b ? p.bow_b : p.bow_a);
      force[0] += bow * std::cos(theta + p.bow_phase) - p.anisotropy / 2 * k * m.x;
      force[1] += bow * std::sin(theta + p.bow_phase) + p.anisotropy / 2 * k * m.y;
      if (p.crack_depth != 0) {
        const double u = theta + p.crack_phase, nx = std::cos(u), ny = std::sin(u);
        const double f = p.crack_depth * k * (1 + nx) / 2 * (nx * m.x + ny * m.y);
        force[0] += f * nx, force[1] += f * ny;
      }
      // laws of no catalogue, at each bearing: -q |v| v, -c r^2 (x, y), a force three times a turn, dry friction
      const double speed = std::hypot(m.vx, m.vy), r2 = m.x * m.x + m.y * m.y;
      const double drag = p.law_quadratic * speed + p.law_dry / std::hypot(speed, 1e-4);
      force[0] += -drag * m.vx - p.law_cubic * r2 * m.x + p.law_third * std::cos(3 * theta + p.law_third_phase);
      force[1] += -drag * m.vy - p.law_cubic * r2 * m.y + p.law_third * std::sin(3 * theta + p.law_third_phase);
      bearing_push(z, shape, force[0], force[1]);
    }
    // Forces elsewhere on the shaft, against the stator.
    if (p.cross_q != 0) {
      const Motion m = motion(p.cross_z, 0);
      const double q = p.cross_q * std::pow(w / (2 * kPi * p.cross_hz), p.cross_exponent);
      push(p.cross_z, 0, -q * m.y, q * m.x);
    }
    if (p.internal_d != 0) {
      const Motion m = motion(p.internal_z, 0);
      push(p.internal_z, 0, -p.internal_d * (m.vx + w * m.y), -p.internal_d * (m.vy - w * m.x));
    }
    if (p.pull_k != 0) {
      const Motion m = motion(p.pull_z, 0);
      push(p.pull_z, 0, p.pull_k * m.x, p.pull_k * m.y);
    }
    // Auxiliary bearings.
    for (int b = 0; b < 2; ++b) {
      const double z = b ? p.z_aux_b : p.z_aux_a, shape = b ? p.shape_aux_b : p.shape_aux_a;
      Motion m = motion(z, shape);
      m.x -= b ? p.offset_bx : p.offset_ax, m.y -= b ? p.offset_by : p.offset_ay;
      const int at = b ? MBX : MAX_;
      if (p.mount) {  // the coordinates of a mount are those against the inertial frame
        m.x -= s[at] - s[FX], m.y -= s[at + 1] - s[FY];
        m.vx -= s[VEL + at] - s[VEL + FX], m.vy -= s[VEL + at + 1] - s[VEL + FY];
      }
      const double r = std::hypot(m.x, m.y), depth = r - p.clearance;
      double cx = 0, cy = 0;
      d[b ? RB : RA] = 0;
      double ring_torque = 0;
      if (depth > 0) {
        const double nx = m.x / r, ny = m.y / r, rate = nx * m.vx + ny * m.vy;
        double normal = p.hertz ? p.hertz_k * std::pow(depth, 1.5) * (1 + p.hertz_l * rate)
                                : p.contact_k * depth + p.contact_d * rate;
        normal = std::max(normal, 0.0);
        double slip = p.radius * w + nx * m.vy - ny * m.vx;
        if (p.ring) slip -= (p.radius + p.clearance) * s[b ? RB : RA];
        const double mu = p.stribeck ? p.mu_dynamic + (p.mu_static - p.mu_dynamic) *
                                                          std::exp(-std::abs(slip) / p.stribeck_speed)
                                     : p.friction;
        const double drag = mu * normal * std::tanh(slip / kSlipSpeed);
        cx = -normal * nx + drag * ny, cy = -normal * ny - drag * nx;
        ring_torque = drag * (p.radius + p.clearance);
      }
      if (p.ring) {  // a ring at rest stays so under less than its drag: the sign is smoothed over 1 rad/s
        d[b ? RB : RA] = (ring_torque - p.ring_drag * std::tanh(s[b ? RB : RA])) / p.ring_inertia;
      }
      push(z, shape, cx, cy);
      if (p.mount) {
        const double sx = p.mount_k * (s[at] - s[FX]) + p.mount_d * (s[VEL + at] - s[VEL + FX]);
        const double sy = p.mount_k * (s[at + 1] - s[FY]) + p.mount_d * (s[VEL + at + 1] - s[VEL + FY]);
        d[VEL + at] = (-cx - sx) / p.mount_mass, d[VEL + at + 1] = (-cy - sy) / p.mount_mass;
        rx += sx, ry += sy;
      } else {
        d[VEL + at] = d[VEL + at + 1] = 0;
        rx -= cx, ry -= cy;
      }
    }
    for (int j = 0; j < NPOS; ++j) d[j] = s[VEL + j];
    double* a = &d[VEL];
    const double* v = &s[VEL];
    a[XG] = fx / p.mass, a[YG] = fy / p.mass;
    a[AL] = (ma - p.polar_inertia * w * v[BE]) / p.transverse_inertia;
    a[BE] = (mb + p.polar_inertia * w * v[AL]) / p.transverse_inertia;
    const double o = 2 * kPi * p.flex_hz, g = 2 * kPi * p.foundation_hz;
    a[QX] = p.flexible ? qx / p.mass - 2 * p.flex_ratio * o * v[QX] - o * o * s[QX] : 0;
    a[QY] = p.flexible ? qy / p.mass - 2 * p.flex_ratio * o * v[QY] - o * o * s[QY] : 0;
    a[FX] = p.foundation ? rx / p.foundation_mass - 2 * p.foundation_ratio * g * v[FX] - g * g * s[FX] : 0;
    a[FY] = p.foundation ? ry / p.foundation_mass - 2 * p.foundation_ratio * g * v[FY] - g * g * s[FY] : 0;
    if (laws_apart) addLawsApart(theta, w, s, current, d);
  }

  // Laws of no catalogue at one plane of a rigid shaft, against its tilt, and at both bearings. Apart from derivative()
  // and called only for them: in there they would move the last bits of sets that do not have them.
  [[gnu::noinline]] void addLawsApart(double theta, double w, const State& s, const std::array<double, 4>& current,
                                      State& d) const {
    const double* v = &s[VEL];
    double* a = &d[VEL];
    const auto push = [&](double z, double shape, double x, double y) {
      a[XG] += x / p.mass, a[YG] += y / p.mass;
      a[AL] -= z * y / p.transverse_inertia, a[BE] += z * x / p.transverse_inertia;
      if (p.flexible) a[QX] += shape * x / p.mass, a[QY] += shape * y / p.mass;
    };
    // -c |v| v, -c |p|^2 p, -c |W| v, f exp(j (3 angle + phase))
    const double z = p.law_z_m, third = 3 * theta + p.law_plane_third_phase;
    const double x = s[XG] + z * s[BE] - s[FX], y = s[YG] - z * s[AL] - s[FY];
    const double vx = v[XG] + z * v[BE] - v[FX], vy = v[YG] - z * v[AL] - v[FY];
    const double damping = p.law_plane_quadratic * std::hypot(vx, vy) + p.law_plane_speed * std::abs(w);
    const double spring = p.law_plane_cubic * (x * x + y * y);
    push(z, 0, -damping * vx - spring * x + p.law_plane_third * std::cos(third),
         -damping * vy - spring * y + p.law_plane_third * std::sin(third));
    // moments -c |tilt|^2 tilt, -c |rate| rate
    const double erect = p.law_tilt_cubic * (s[AL] * s[AL] + s[BE] * s[BE]);
    const double drag = p.law_tilt_drag * std::hypot(v[AL], v[BE]);
    a[AL] -= (erect * s[AL] + drag * v[AL]) / p.transverse_inertia;
    a[BE] -= (erect * s[BE] + drag * v[BE]) / p.transverse_inertia;
    // c W |p| (-y, x), -c |i|^2 (x, y)
    for (int b = 0; b < 2 && on; ++b) {
      const double zb = b ? p.z_amb_b : p.z_amb_a, shape = b ? p.shape_amb_b : p.shape_amb_a;
      const double px = s[XG] + zb * s[BE] + shape * s[QX] - s[FX], py = s[YG] - zb * s[AL] + shape * s[QY] - s[FY];
      const double ix = current[2 * b], iy = current[2 * b + 1];
      const double swirl = p.law_swirl * w * std::hypot(px, py), stiff = p.law_current * (ix * ix + iy * iy);
      const double fx = -swirl * py - stiff * px, fy = swirl * px - stiff * py;
      push(zb, shape, fx, fy);
      if (p.foundation) a[FX] -= fx / p.foundation_mass, a[FY] -= fy / p.foundation_mass;
    }
  }

  // The four signals with all their errors: rotation, then runout, then gain.
  std::array<double, 4> sensors(double t, const State& s) const {
    double theta, w, slope;
    spin.at(t, theta, w, slope);
    std::array<double, 4> out;
    for (int b = 0; b < 2; ++b) {
      const double z = b ? p.z_sensor_b : p.z_sensor_a, shape = b ? p.shape_sensor_b : p.shape_sensor_a;
      const double x = s[XG] + z * s[BE] + shape * s[QX] - s[FX],
                   y = s[YG] - z * s[AL] + shape * s[QY] - s[FY];
      const double angle = b ? p.angle_b : p.angle_a, c = std::cos(angle), n = std::sin(angle);
      const double r1 = b ? p.runout_b1 : p.runout_a1,
                   u1 = theta + (b ? p.runout_b1_phase : p.runout_a1_phase);
      const double r2 = b ? p.runout_b2 : p.runout_a2;
      const double u2 = 2 * (theta + (b ? p.runout_b2_phase : p.runout_a2_phase));
      out[2 * b] = (b ? p.gain_bx : p.gain_ax) * (x * c + y * n + r1 * std::cos(u1) + r2 * std::cos(u2));
      out[2 * b + 1] = (b ? p.gain_by : p.gain_ay) * (y * c - x * n + r1 * std::sin(u1) - r2 * std::cos(u2));
    }
    return out;
  }

  // What laws of no catalogue add to a displacement q that is sensed: play -sign(q) min(|q|, d), c q^3,
  // L tanh(q/L) - q, c |W| q.
  double misread(double q, double w) const {
    double change = -std::copysign(std::min(std::abs(q), p.law_sensor_play), q) + p.law_sensor_cubic * q * q * q +
                    p.law_sensor_speed * std::abs(w) * q;
    if (p.law_sensor_limit > 0) change += p.law_sensor_limit * std::tanh(q / p.law_sensor_limit) - q;
    return change;
  }

  // What they change in the four signals: they act on x and y at the sensor's plane, rotation, runout and gain come on top.
  // Apart from sensors() for the reason that addLawsApart is; added to what `signal` and `out` hold already for that, too.
  [[gnu::noinline]] std::array<double, 4> sensorLaws(double t, const State& s) const {
    std::array<double, 4> out;
    double theta, w, slope;
    spin.at(t, theta, w, slope);
    for (int b = 0; b < 2; ++b) {
      const double z = b ? p.z_sensor_b : p.z_sensor_a, shape = b ? p.shape_sensor_b : p.shape_sensor_a;
      const double x = misread(s[XG] + z * s[BE] + shape * s[QX] - s[FX], w);
      const double y = misread(s[YG] - z * s[AL] + shape * s[QY] - s[FY], w);
      const double angle = b ? p.angle_b : p.angle_a, c = std::cos(angle), n = std::sin(angle);
      out[2 * b] = (b ? p.gain_bx : p.gain_ax) * (x * c + y * n);
      out[2 * b + 1] = (b ? p.gain_by : p.gain_ay) * (y * c - x * n);
    }
    return out;
  }
};

}  // namespace

extern "C" const char* parameter_names() {
#define P(name) #name " "
  return PARAMETERS(P);
#undef P
}

// Records n_records x 8: the four signals [m], the four control currents [A], at m/record_hz. `settle` [s] of
// run-in from rest at the starting speed, without excitation. `excitation`: n_records x 4 [A] or null, each
// row held until the next; `events`: n x 2, time and 1 for amb_on, 0 for amb_off. `disturbance`: n_records x
// 4 [m] or null, added to the signals that the controller reads (noise that goes round the loop), not to what
// is recorded. `offsets`: 2 x 4 [m] or null, likewise: what the sensors are off by from the run-in on, and how far they
// drift from the first record to the last.
extern "C" int simulate(const double* values, const double* unbalances, int n_unbalances, const double* knots,
                        int n_knots, double angle, double settle, double step, double record_hz,
                        int n_records, const double* excitation, const double* events, int n_events,
                        const double* disturbance, const double* offsets, double* out) {
  Machine m;
  std::memcpy(&m.p, values, sizeof(Parameters));
  const Parameters& p = m.p;
  for (int i = 0; i < n_unbalances; ++i) {
    const double* u = unbalances + 4 * i;
    m.unbalance.push_back({u[0], u[1], u[2], u[3]});
  }
  for (int i = 0; i < n_knots; ++i) {
    const double t = knots[2 * i], w = knots[2 * i + 1];
    if (i > 0) angle += 0.5 * (w + m.spin.w.back()) * (t - m.spin.t.back());
    m.spin.t.push_back(t), m.spin.w.push_back(w), m.spin.angle.push_back(angle);
  }
  m.k = p.equivalent ? p.equivalent_k : p.ki_force * p.kp - p.ks;
  for (double c : {p.law_plane_quadratic, p.law_plane_cubic, p.law_plane_speed, p.law_plane_third, p.law_tilt_cubic,
                   p.law_tilt_drag, p.law_swirl, p.law_current})
    m.laws_apart = m.laws_apart || c != 0;
  for (double c : {p.law_sensor_play, p.law_sensor_cubic, p.law_sensor_limit, p.law_sensor_speed})
    m.laws_of_sensors = m.laws_of_sensors || c != 0;
  const double period = 1 / p.control_hz, a = std::exp(-2 * kPi * p.filter_hz * period);
  const double lag = 2 * kPi * p.amplifier_hz,
               limit = std::min(p.bias_current, p.max_current - p.bias_current);
  const double tiny = 1e-10;

  State s{};
  std::array<double, 4> command{}, exc{}, current{}, force_current{}, last{}, filtered{}, integral{};
  std::deque<std::pair<double, std::array<double, 4>>> under_way;
  Eddy eddy(2 * kPi * p.eddy_hz);
  long sample = std::lround(std::floor(-settle * p.control_hz));
  int record = 0, event = 0, held = 0;
  double t = sample * period;
  bool first = true;
  while (true) {
    // What happens at this instant.
    for (; event < n_events && events[2 * event] <= t + tiny; ++event) m.on = events[2 * event + 1] > 0.5;
    if (excitation && held < n_records && held / record_hz <= t + tiny) {
      while (held + 1 < n_records && (held + 1) / record_hz <= t + tiny) ++held;
      for (int c = 0; c < 4; ++c) exc[c] = excitation[4 * held + c];
      ++held;
    }
    if (record < n_records && record / record_hz <= t + tiny) {
      const auto signal = m.sensors(t, s);
      for (int c = 0; c < 4; ++c) out[8 * record + c] = signal[c], out[8 * record + 4 + c] = current[c];
      if (m.laws_of_sensors) {
        const auto change = m.sensorLaws(t, s);
        for (int c = 0; c < 4; ++c) out[8 * record + c] += change[c];
      }
      if (++record == n_records) return 0;
    }
    if (sample * period <= t + tiny) {
      auto signal = m.sensors(t, s);
      const long row = std::lround(t * record_hz);
      if (disturbance && row >= 0 && row < n_records)
        for (int c = 0; c < 4; ++c) signal[c] += disturbance[4 * row + c];
      if (offsets)
        for (int c = 0; c < 4; ++c)
          signal[c] += offsets[c] + offsets[4 + c] * std::max(0.0, t) * record_hz / std::max(1, n_records - 1);
      if (m.laws_of_sensors) {
        const auto change = m.sensorLaws(t, s);
        for (int c = 0; c < 4; ++c) signal[c] += change[c];
      }
      std::array<double, 4> i;
      for (int c = 0; c < 4; ++c) {
        if (first) last[c] = signal[c];
        filtered[c] = a * filtered[c] + (1 - a) * (signal[c] - last[c]) / period;
        // "with the integrator at rest": zero until the recording begins, or, the other reading, settled as
        // all else is
        if (t > -tiny || p.integral_settled) integral[c] += period * signal[c];
        last[c] = signal[c];
        i[c] = -(p.kp * signal[c] + p.kd * filtered[c] + p.ki * integral[c]);
        if (!(std::abs(signal[c]) < 0.1)) return 1;  // diverged
      }
      first = false;
      under_way.push_back({sample * period + p.delay, i});
      ++sample;
    }
    while (!under_way.empty() && under_way.front().first <= t + tiny) {
      command = under_way.front().second;
      under_way.pop_front();
    }
    // The next instant at which something happens.
    double next = sample * period;
    if (!under_way.empty()) next = std::min(next, under_way.front().first);
    if (record < n_records) next = std::min(next, std::max(record / record_hz, t + tiny));
    if (excitation && held < n_records) next = std::min(next, held / record_hz);
    if (event < n_events) next = std::min(next, events[2 * event]);
    const double largest = t < 0 ? std::max(step, 2e-5) : step;  // the run-in is away from contact
    const int steps = std::max(1, static_cast<int>(std::ceil((next - t) / largest - 1e-6)));
    const double h = (next - t) / steps;
    std::array<double, 4> target;
    for (int c = 0; c < 4; ++c) target[c] = m.on ? std::clamp(command[c] + exc[c], -limit, limit) : 0.0;
    const double half = std::exp(-lag * h / 2), slowest = t < -0.3 * settle ? 5.0 : 0.0;
    for (int n = 0; n < steps; ++n) {
      std::array<double, 4> i0 = p.eddy ? force_current : current, i1, i2;
      for (int c = 0; c < 4; ++c) {
        const double middle = target[c] + (current[c] - target[c]) * half;
        const double end = target[c] + (middle - target[c]) * half;
        if (p.eddy) {
          i1[c] = eddy.advance(c, current[c], middle, h / 2, slowest);
          i2[c] = eddy.advance(c, middle, end, h / 2, slowest);
        } else {
          i1[c] = middle, i2[c] = end;
        }
        current[c] = end;
      }
      force_current = i2;
      State k1, k2, k3, k4, u;
      m.derivative(t, s, i0, k1);
      for (int j = 0; j < NSTATE; ++j) u[j] = s[j] + h / 2 * k1[j];
      m.derivative(t + h / 2, u, i1, k2);
      for (int j = 0; j < NSTATE; ++j) u[j] = s[j] + h / 2 * k2[j];
      m.derivative(t + h / 2, u, i1, k3);
      for (int j = 0; j < NSTATE; ++j) u[j] = s[j] + h * k3[j];
      m.derivative(t + h, u, i2, k4);
      for (int j = 0; j < NSTATE; ++j) s[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
      t += h;
    }
    t = next;
  }
}
