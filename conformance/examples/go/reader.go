package main

import "math/bits"

// fault is the first fault of a stream (CNF-7, CNF-21). It travels as a panic value from where it is found to decode.
type fault struct {
	Class string `json:"class"`
	Rule  string `json:"rule"`
	Bits  [2]int `json:"bits"`
}

func reject(class, rule string, first, end int) {
	panic(&fault{class, rule, [2]int{first, end}})
}

// reader takes raw bits, most significant first.
type reader struct {
	data    []byte
	pos     int
	end     int
	content int // behind the last bit that is 1
}

func newReader(data []byte) *reader {
	r := &reader{data: data, end: 8 * len(data)}
	for i, b := range data {
		if b != 0 {
			r.content = 8*i + 8 - bits.TrailingZeros8(b)
		}
	}
	return r
}

// at is the bit at a position; behind the end of the data it is 0 (FBA-27).
func (r *reader) at(pos int) uint32 {
	if pos >= r.end {
		return 0
	}
	return uint32(r.data[pos>>3]>>(7-pos&7)) & 1
}

// is says whether the n bits at pos exist and are v.
func (r *reader) is(pos, n int, v uint32) bool {
	return pos+n <= r.end && r.value(pos, n) == v
}

func (r *reader) value(pos, n int) (v uint32) {
	for i := 0; i < n; i++ {
		v = v<<1 | r.at(pos+i)
	}
	return v
}

func (r *reader) u(n int, rule string) uint32 {
	if r.pos+n > r.end {
		reject("Truncated", rule, r.pos, r.end)
	}
	r.pos += n
	return r.value(r.pos-n, n)
}

func (r *reader) flag(rule string) bool {
	return r.u(1, rule) == 1
}

func (r *reader) marker(rule string) {
	if !r.flag(rule) {
		r.rejectLast("MarkerBit", rule, 1)
	}
}

// rejectLast rejects the n bits that were just read.
func (r *reader) rejectLast(class, rule string, n int) {
	reject(class, rule, r.pos-n, r.pos)
}

// upTo reads a field that has a largest value.
func (r *reader) upTo(n int, most uint32, rule string) uint32 {
	v := r.u(n, rule)
	if v > most {
		r.rejectLast("ForbiddenValue", rule, n)
	}
	return v
}

// stuffed says whether exactly the stuffing of FBA-3 stands here, and where it ends.
func (r *reader) stuffed() (int, bool) {
	n := 8 - r.pos%8
	return r.pos + n, r.is(r.pos, n, 1<<(n-1)-1)
}
