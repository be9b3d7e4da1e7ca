// What two sections say along their common line.
#include <algorithm>
#include <map>

#include "transect/cpp/skeleton/sections.h"

namespace transect::skeleton {
namespace {

// The labels in front of and behind the other plane.
struct State {
  Label front, behind;
  bool operator==(const State& other) const {
    return front == other.front && behind == other.behind;
  }
  bool is_simple() const { return front == behind; }
  bool has(Label label) const { return front == label || behind == label; }
  bool is_known() const { return front != unknown && behind != unknown; }
};

// A place where pieces meet the line, with what is said after it.
struct Event {
  Index point;
  Number place;
  State before, after;
};

// What one section says along the line, in the line's direction.
struct Profile {
  std::vector<Event> events;
  State start;
};

// The ends of pieces on the lines with other planes: `at[other]` are pairs of a
// point and a piece.
struct Ends {
  std::vector<std::vector<std::pair<Index, Index>>> at;

  Ends(const Scene& scene, Index own) : at(scene.sections.size()) {
    const auto& pieces = scene.sections[own].pieces;
    for (Index piece = 0; piece < pieces.size(); ++piece) {
      for (Index point : {pieces[piece].from, pieces[piece].to}) {
        for (Index other = 0; other < at.size(); ++other) {
          if (other == own || scene.points.side(point, other) != 0) continue;
          at[other].push_back({point, piece});
        }
      }
    }
  }
};

// The line of planes a < b; its direction is the product of their normals.
struct Line {
  Index a, b;
  Vector direction;

  Line(const Scene& scene, Index a, Index b)
      : a(a),
        b(b),
        direction(CGAL::cross_product(scene.planes[a].normal, scene.planes[b].normal)) {}

  Number place(const Point& point) const { return direction * (point - CGAL::ORIGIN); }
};

// The label after some pieces on one side of the line are passed: what is
// entered and left at one place cancels, in whatever order.
Label passed(Label before, const std::vector<State>& crossed) {
  std::map<Label, int> balance{{before, 1}};
  for (const State& labels : crossed) {  // `front` is entered, `behind` left
    ++balance[labels.front];
    --balance[labels.behind];
  }
  const auto most = std::max_element(
      balance.begin(), balance.end(),
      [](const auto& one, const auto& other) { return one.second < other.second; });
  return most->first;
}

Profile profile(const Scene& scene, const Line& line, Index own, const Ends& ends) {
  const Index other = own == line.a ? line.b : line.a;
  const Section& section = scene.sections[own];
  std::map<Index, std::vector<Index>> pieces_at;
  for (const auto& [point, piece] : ends.at[other]) pieces_at[point].push_back(piece);
  Profile result{{}, {section.background, section.background}};
  for (const auto& [point, pieces] : pieces_at) {
    result.events.push_back({point, line.place(scene.points[point]), {}, {}});
  }
  std::sort(result.events.begin(), result.events.end(), [](const Event& one, const Event& two) {
    return one.point != two.point && one.place < two.place;
  });
  State state = result.start;
  for (Event& event : result.events) {
    std::vector<State> crossed[2];
    for (Index index : pieces_at[event.point]) {
      const Piece& piece = section.pieces[index];
      const bool leaves = piece.from == event.point;
      const auto side = scene.points.side(leaves ? piece.to : piece.from, other);
      if (side == 0) continue;
      const Label left = leaves ? piece.left : piece.right;
      const Label right = leaves ? piece.right : piece.left;
      // In front of b is right of the line on a, in front of a left of it on b.
      const bool to_right = (side > 0) == (own == line.a);
      crossed[side > 0 ? 0 : 1].push_back(to_right ? State{left, right} : State{right, left});
    }
    event.before = state;
    state = {passed(state.front, crossed[0]), passed(state.behind, crossed[1])};
    event.after = state;
  }
  return result;
}

// Ends of pieces that were moved onto others: the point instead of each.
using Moves = std::map<Index, Index>;

Index moved(const Moves& moves, Index point) {
  for (auto found = moves.find(point); found != moves.end(); found = moves.find(point)) {
    point = found->second;
  }
  return point;
}

Piece moved(const Moves& moves, const Piece& piece) {
  return {moved(moves, piece.from), moved(moves, piece.to), piece.left, piece.right};
}

// Finds the places on a line where both sections change between the same labels.
class Matching {
 public:
  Matching(const Scene& scene, double tolerance, Index first_cut, Moves& moves)
      : scene_(scene), tolerance_(tolerance), first_cut_(first_cut), moves_(moves) {}

  void match(const Profile& a, const Profile& b) {
    std::size_t next = 0;
    for (const Event& event : a.events) {
      if (!is_change(event)) continue;
      for (std::size_t i = next; i < b.events.size(); ++i) {
        if (!is_same(event, b.events[i])) continue;
        unite(event.point, b.events[i].point);
        next = i + 1;
        break;
      }
    }
  }

 private:
  static bool is_change(const Event& event) {
    return event.before.is_simple() && event.after.is_simple() && !(event.before == event.after);
  }

  bool is_same(const Event& one, const Event& other) const {
    if (!(one.before == other.before && one.after == other.after)) return false;
    const Point &a = scene_.points[one.point], &b = scene_.points[other.point];
    return one.point == other.point ||
           CGAL::to_double(CGAL::squared_distance(a, b)) <= tolerance_ * tolerance_;
  }

  // A cut may move along its line, if it is on no other.
  bool is_free(Index point, Index onto) const {
    if (point < first_cut_ || moves_.count(point) != 0) return false;
    const Sides &from = scene_.points.sides(point), &to = scene_.points.sides(onto);
    for (std::size_t plane = 0; plane < from.size(); ++plane) {
      if ((from[plane] == 0) != (to[plane] == 0)) return false;
    }
    return true;
  }

  void unite(Index one, Index other) {
    one = moved(moves_, one);
    other = moved(moves_, other);
    if (one == other) return;
    if (is_free(other, one)) {
      moves_[other] = one;
    } else if (is_free(one, other)) {
      moves_[one] = other;
    }
  }

  const Scene& scene_;
  double tolerance_;
  Index first_cut_;
  Moves& moves_;
};

// Whether a piece keeps to one side of every plane.
bool is_uncut(const Scene& scene, const Piece& piece) {
  const Sides &from = scene.points.sides(piece.from), &to = scene.points.sides(piece.to);
  for (std::size_t plane = 0; plane < from.size(); ++plane) {
    if (from[plane] * to[plane] < 0) return false;
  }
  return true;
}

// Whether two pieces of a plane, whose boxes overlap, meet elsewhere than in a common end.
bool collide(const Scene& scene, const Piece& a, const Piece& b, const View& view) {
  const auto segment = [&](const Piece& piece) {
    return Kernel::Segment_2(view(scene.points[piece.from]), view(scene.points[piece.to]));
  };
  const bool from = a.from == b.from || a.from == b.to, to = a.to == b.from || a.to == b.to;
  if (from && to) return true;
  if (!from && !to) return CGAL::do_intersect(segment(a), segment(b));
  const Index shared = from ? a.from : a.to;
  const Index far = from ? a.to : a.from, other = b.from == shared ? b.to : b.from;
  return segment(b).has_on(view(scene.points[far])) || segment(a).has_on(view(scene.points[other]));
}

// Takes back moves that make a piece cross a plane or another piece of its
// section; whether there was one.
bool take_back(const Scene& scene, Index own, Moves& moves) {
  const View view(scene.planes[own].normal);
  const auto& pieces = scene.sections[own].pieces;
  std::vector<Piece> after;
  std::vector<CGAL::Bbox_3> boxes;
  for (const Piece& piece : pieces) {
    after.push_back(moved(moves, piece));
    const auto& [from, to, left, right] = after.back();
    boxes.push_back(scene.points[from].bbox() + scene.points[to].bbox());
  }
  std::vector<Index> wrong;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (after[i].from == pieces[i].from && after[i].to == pieces[i].to) continue;
    bool sound = after[i].from != after[i].to && is_uncut(scene, after[i]);
    for (std::size_t j = 0; j < pieces.size() && sound; ++j) {
      sound = j == i || !CGAL::do_overlap(boxes[i], boxes[j]) ||
              !collide(scene, after[i], after[j], view);
    }
    if (!sound) wrong.insert(wrong.end(), {pieces[i].from, pieces[i].to});
  }
  std::size_t count = 0;
  for (Index point : wrong) count += moves.erase(point);
  return count > 0;
}

// A place where one or both sections have an event.
struct Step {
  Index point;
  const State* after[2];
};

std::vector<Step> steps(const Profile& a, const Profile& b) {
  std::vector<Step> result;
  auto one = a.events.begin(), other = b.events.begin();
  while (one != a.events.end() || other != b.events.end()) {
    const bool take_one = one != a.events.end(), take_other = other != b.events.end();
    const auto order = !take_one                    ? CGAL::LARGER
                       : !take_other                ? CGAL::SMALLER
                       : one->point == other->point ? CGAL::EQUAL
                                                    : CGAL::compare(one->place, other->place);
    Step step{order == CGAL::LARGER ? other->point : one->point, {nullptr, nullptr}};
    if (order != CGAL::LARGER) step.after[0] = &(one++)->after;
    if (order != CGAL::SMALLER) step.after[1] = &(other++)->after;
    result.push_back(step);
  }
  return result;
}

bool contradict(const State& a, const State& b) {
  return a.is_known() && b.is_known() && !a.has(b.front) && !a.has(b.behind);
}

void list_contradictions(Scene& scene, const Line& line, const Profile& a, const Profile& b) {
  State states[2] = {a.start, b.start};
  bool open = false;
  for (const Step& step : steps(a, b)) {
    for (int which : {0, 1}) {
      if (step.after[which]) states[which] = *step.after[which];
    }
    const bool now = contradict(states[0], states[1]);
    if (now && !open) scene.contradictions.push_back({{line.a, line.b}, step.point, none, {}});
    if (!now && open) scene.contradictions.back().to = step.point;
    for (int which : {0, 1}) {
      if (!now) continue;
      auto& labels = scene.contradictions.back().labels[which];
      if (labels.empty() || labels.back() != states[which].front) {
        labels.push_back(states[which].front);
      }
    }
    open = now;
  }
  // Beyond the last event both are what they are far away.
  if (open) scene.contradictions.pop_back();
}

template <typename Visit>
void for_each_line(const Scene& scene, Visit visit) {
  std::vector<Ends> ends;
  for (Index plane = 0; plane < scene.sections.size(); ++plane) ends.emplace_back(scene, plane);
  for (Index a = 0; a < scene.sections.size(); ++a) {
    for (Index b = a + 1; b < scene.sections.size(); ++b) {
      if (ends[a].at[b].empty() && ends[b].at[a].empty()) continue;
      const Line line(scene, a, b);
      if (line.direction == CGAL::NULL_VECTOR) continue;
      visit(line, profile(scene, line, a, ends[a]), profile(scene, line, b, ends[b]));
    }
  }
}

}  // namespace

void reconcile(Scene& scene, double tolerance, Index first_cut) {
  Moves moves;
  Matching matching(scene, tolerance, first_cut, moves);
  for_each_line(scene,
                [&](const Line&, const Profile& a, const Profile& b) { matching.match(a, b); });
  for (bool again = true; again;) {
    again = false;
    for (Index plane = 0; plane < scene.sections.size(); ++plane) {
      again = take_back(scene, plane, moves) || again;
    }
  }
  for (Section& section : scene.sections) {
    for (Piece& piece : section.pieces) piece = moved(moves, piece);
  }
  scene.snapped = moves.size();
}

void find_contradictions(Scene& scene) {
  for_each_line(scene, [&](const Line& line, const Profile& a, const Profile& b) {
    list_contradictions(scene, line, a, b);
  });
}

}  // namespace transect::skeleton
