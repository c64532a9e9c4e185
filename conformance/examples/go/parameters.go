package main

// limits in the order of the lists of FBA-16.
type limits [4]int64

const (
	iMax = iota
	iMin
	pMax
	pMin
)

// parameter is one coded number: a FAP of 3..68, a symbol of FAP 1 or 2, or a BAP.
type parameter struct {
	sent     limits // as sent, or the defaults, undivided (FBA-19)
	inForce  limits
	step     int64
	value    int64
	intra    model
	adaptive model
}

func (p *parameter) prepare(inForce limits, step int64) {
	p.inForce, p.step = inForce, step
	p.intra.reset(int(inForce[iMax] - inForce[iMin] + 1))
	p.adaptive.reset(int(inForce[pMax] - inForce[pMin] + 1))
}

func (p *parameter) divided(by int64) limits {
	l := p.sent
	for i := range l {
		l[i] /= max(by, 1)
	}
	return l
}

// decode reads one segment with the given parameters (FBA-28, FBA-31, FBA-32).
func decode(r *reader, intra bool, parameters []*parameter) {
	s := openSegment(r)
	for _, p := range parameters {
		var level int64
		if intra {
			level = int64(s.symbol(&p.intra)) + p.inForce[iMin]
			p.value = 0
		} else {
			symbol := s.symbol(&p.adaptive)
			p.adaptive.learn(symbol)
			level = int64(symbol) + p.inForce[pMin]
		}
		if p.step != 0 {
			level *= p.step
		}
		p.value += level
	}
	s.close(r)
}

// group holds a group's members; nil stands for one that is not selected.
type group []*parameter

// newMinmax is FBA-16.
func newMinmax(r *reader, groups []group) (given [4]bool) {
	for i := range given {
		given[i] = r.flag("FBA-13")
	}
	for i := range given {
		if !given[i] {
			continue
		}
		for _, g := range groups {
			for place, p := range g {
				if place%4 == 0 {
					r.marker("FBA-16")
				}
				if p == nil {
					continue
				}
				p.sent[i] = 60 * int64(r.u(5, "FBA-16"))
				if i == iMin || i == pMin {
					p.sent[i] = -p.sent[i]
				}
			}
		}
	}
	return given
}

// face is the state of the FAPs, by number; index 0 is not used.
type face struct {
	seen       bool
	low        [69]parameter
	viseme     [3]parameter
	expression [4]parameter

	visemeDef, initFace, expressionDef int

	maskType [69]uint32
	coded    [69]bool
	ever     [69]bool
	state    [69]byte
	order    []*parameter // the coded FAPs of 3..68
}

func newFace() *face {
	f := &face{}
	for n := 1; n <= 68; n++ {
		f.state[n] = 'U'
		i, p := (fapIntraMax[n]+59)/60*60, (fapInterMax[n]+59)/60*60 // FBA-18
		f.low[n].sent = limits{i, -i, p, -p}
	}
	return f
}

// header is FBA-9..19, FBA-29..31.
func (f *face) header(r *reader) {
	quant := int64(r.u(5, "FBA-9"))
	n := 1
	for _, size := range fapGroupSizes {
		r.marker("FBA-10")
		kind := r.u(2, "FBA-10")
		var mask uint32
		if kind == 1 || kind == 2 {
			mask = r.u(size, "FBA-10")
		}
		for i := size - 1; i >= 0; i-- {
			f.maskType[n] = kind
			f.coded[n] = kind == 3 || mask>>i&1 == 1
			n++
		}
	}
	r.u(1, "FBA-11")
	if r.flag("FBA-12") {
		r.rejectLast("Unsupported", "FBA-12", 1)
	}
	f.order = f.order[:0]
	var groups []group
	n = 3
	for _, size := range fapGroupSizes[1:] {
		g := make(group, size)
		for i := range g {
			if f.coded[n] {
				g[i] = &f.low[n]
				f.order = append(f.order, g[i])
			}
			n++
		}
		groups = append(groups, g)
	}
	newMinmax(r, groups)
	for n := 3; n <= 68; n++ {
		if f.coded[n] {
			f.low[n].prepare(f.low[n].divided(quant), fapQP[n]*quant)
		}
	}
	m := (63 + quant/2) / max(quant, 1)
	for i := range f.viseme {
		most, step := int64(14), int64(1)
		if i == 2 {
			most, step = m, quant
		}
		if f.coded[1] {
			f.viseme[i].prepare(limits{most, 0, most, -most}, step)
		}
	}
	for i := range f.expression {
		most, step := int64(6), int64(1)
		if i%2 == 1 {
			most, step = m, quant
		}
		if f.coded[2] {
			f.expression[i].prepare(limits{most, 0, most, -most}, step)
		}
	}
}

func checkSelects(r *reader, start int, most int64, selects ...parameter) {
	for _, p := range selects {
		if p.value < 0 || p.value > most {
			reject("RangeViolation", "FBA-32", start, r.pos)
		}
	}
}

// data is the FAP data of a plane: FBA-28, FBA-34.
func (f *face) data(r *reader, intra bool) {
	if intra {
		f.header(r)
		f.seen = true
	}
	if f.coded[1] {
		start := r.pos
		decode(r, intra, []*parameter{&f.viseme[0], &f.viseme[1], &f.viseme[2]})
		checkSelects(r, start, 14, f.viseme[0], f.viseme[1])
		f.visemeDef = int(r.u(1, "FBA-28"))
	}
	if f.coded[2] {
		start := r.pos
		decode(r, intra, []*parameter{&f.expression[0], &f.expression[1], &f.expression[2], &f.expression[3]})
		checkSelects(r, start, 6, f.expression[0], f.expression[2])
		f.initFace = int(r.u(1, "FBA-28"))
		f.expressionDef = int(r.u(1, "FBA-28"))
	}
	decode(r, intra, f.order)
	for n := 1; n <= 68; n++ {
		switch {
		case f.coded[n]:
			f.state[n] = 'T'
			f.ever[n] = true
		case f.maskType[n] == 2:
			f.state[n] = 'I'
		case f.ever[n]:
			f.state[n] = 'R'
		default:
			f.state[n] = 'U'
		}
	}
}

func (f *face) noData() {
	for n, state := range f.state {
		if state == 'T' {
			f.state[n] = 'R'
		}
	}
}

func (f *face) has(n int) bool {
	return f.state[n] == 'T' || f.state[n] == 'R'
}

// body is the state of the BAPs, by number (FBA-40).
type body struct {
	seen  bool
	baps  [297]parameter
	coded []int // in coding order
}

func newBody() *body {
	b := &body{}
	for i, row := range bapRows {
		copy(b.baps[i+1].sent[:], row[1:])
	}
	return b
}

func (b *body) data(r *reader, intra bool) {
	if intra {
		b.header(r)
		b.seen = true
	}
	order := make([]*parameter, len(b.coded))
	for i, n := range b.coded {
		order[i] = &b.baps[n]
	}
	decode(r, intra, order)
}

func (b *body) header(r *reader) {
	scale := bapScale[r.u(5, "FBA-40")]
	b.coded = b.coded[:0]
	var groups []group
	for _, numbers := range bapGroups {
		r.marker("FBA-40")
		kind := r.u(2, "FBA-40")
		var mask uint32
		switch kind {
		case 1:
			mask = r.u(len(numbers), "FBA-40")
		case 2:
			r.rejectLast("ForbiddenValue", "FBA-40", 2)
		case 3:
			mask = 1<<len(numbers) - 1
		}
		g := make(group, len(numbers))
		for i, n := range numbers {
			if mask>>(len(numbers)-1-i)&1 == 1 {
				g[i] = &b.baps[n]
				b.coded = append(b.coded, n)
			}
		}
		groups = append(groups, g)
	}
	r.u(1, "FBA-40")
	if r.flag("FBA-40") {
		r.rejectLast("Unsupported", "FBA-40", 1)
	}
	start := r.pos
	given := newMinmax(r, groups)
	for _, n := range b.coded {
		base := int64(1)
		if n <= len(bapRows) {
			base = bapRows[n-1][0]
		} else if given != [4]bool{true, true, true, true} {
			reject("Unsupported", "FBA-40", start, r.pos)
		}
		b.baps[n].prepare(b.baps[n].divided(scale), base*scale)
	}
}
