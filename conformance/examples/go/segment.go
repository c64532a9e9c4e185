package main

import "sort"

// The arithmetic decoder as FBA-21..24 write it, with cumulative frequencies.
const (
	q1           = 16384
	q2           = 32768
	q3           = 49152
	top          = 65535
	maxFrequency = 16383
	guardAfter   = 22
)

// model: cum[j] is the sum of the frequencies of the symbols j and up (FBA-22).
type model struct {
	cum []uint32
}

func (m *model) reset(symbols int) {
	if cap(m.cum) <= symbols {
		m.cum = make([]uint32, symbols+1)
	}
	m.cum = m.cum[:symbols+1]
	for j := range m.cum {
		m.cum[j] = uint32(symbols - j)
	}
}

// learn is FBA-24.
func (m *model) learn(s int) {
	if m.cum[0] == maxFrequency {
		halved, above := uint32(0), uint32(0)
		for j := len(m.cum) - 2; j >= 0; j-- {
			frequency := m.cum[j] - above
			above = m.cum[j]
			halved += (frequency + 1) / 2
			m.cum[j] = halved
		}
	}
	for j := 0; j <= s; j++ {
		m.cum[j]++
	}
}

// dataBits yields the data bits of a segment without its guards (FBA-25).
type dataBits struct {
	r     *reader
	pos   int
	zeros int
	guard func(pos int) // told of each guard that is 0
}

func (d *dataBits) next() uint32 {
	if d.zeros == guardAfter {
		if d.guard != nil && d.r.at(d.pos) == 0 {
			d.guard(d.pos)
		}
		d.pos++
		d.zeros = 0
	}
	bit := d.r.at(d.pos)
	d.pos++
	d.zeros++
	if bit == 1 {
		d.zeros = 0
	}
	return bit
}

type segment struct {
	source         dataBits
	low, high      uint32
	code           uint32
	shifts         int
	start, dataEnd int
}

func openSegment(r *reader) *segment {
	s := &segment{source: dataBits{r: r, pos: r.pos}, high: top, start: r.pos, dataEnd: r.end}
	for i := 0; i < 16; i++ {
		s.code = s.code<<1 | s.source.next()
	}
	return s
}

func (s *segment) symbol(m *model) int {
	total := m.cum[0]
	length := s.high - s.low + 1
	c := ((s.code-s.low+1)*total - 1) / length
	symbol := sort.Search(len(m.cum)-2, func(j int) bool { return m.cum[j+1] <= c })
	low := s.low
	s.high = low + length*m.cum[symbol]/total - 1
	s.low = low + length*m.cum[symbol+1]/total
	for {
		var less uint32
		switch {
		case s.high < q2:
		case s.low >= q2:
			less = q2
		case s.low >= q1 && s.high < q3:
			less = q1
		default:
			return symbol
		}
		s.low = 2 * (s.low - less)
		s.high = 2*(s.high-less) + 1
		s.code = 2*(s.code-less) + s.source.next()
		s.shifts++
	}
}

// close walks the 2 + shifts data bits of the segment once more, which gives its end and the guards inside it (FBA-26,
// FBA-27).
func (s *segment) close(r *reader) {
	first := -1
	walk := dataBits{r: r, pos: s.start, guard: func(pos int) {
		if first < 0 {
			first = pos
		}
	}}
	for i := 0; i < 2+s.shifts; i++ {
		walk.next()
	}
	if walk.pos > s.dataEnd {
		reject("Truncated", "FBA-27", s.start, s.dataEnd)
	}
	if first >= 0 {
		reject("MarkerBit", "FBA-25", first, first+1)
	}
	r.pos = walk.pos
}
