"""Tables by hand and creep at rest judged against their truth, by class: a trial beside the tests' benches.

    python -m benchmarks.studies.tables_by_hand FOLDER [CLASSES]
"""
import sys, time, json
from pathlib import Path
import numpy as np
import mbcdm_cad as mc
from mbcdm_cad.loop.search.engine import close_loop
from tests.unit.loop.test_turning_points import locked
from tests.unit.loop import test_creep_at_rest as tc
from tests.unit.planning import test_plan_by_hand as tp
F = Path(sys.argv[1]); F.mkdir(exist_ok=True, parents=True)
only = sys.argv[2].split(",") if len(sys.argv) > 2 else []
def cases():
    for s in range(12): yield "none", set(), lambda s=s: mc.close_loop(None, locked(F, 1300+s, 0., 0., noise=1.5e-4 if s%2 else 4e-5)).result
    for s in range(12):
        r=np.random.default_rng(s); c=10**r.uniform(-4.6,-3.2); p=10**r.uniform(-4,-2.9)
        yield "comp", {"stiffness_error"}, lambda s=s,c=c: mc.close_loop(None, locked(F, 1400+s, c, 0.)).result
        yield "play", {"lash"}, lambda s=s,p=p: mc.close_loop(None, locked(F, 1500+s, 0., p)).result
        yield "both", {"lash","stiffness_error"}, lambda s=s,c=c,p=p: mc.close_loop(None, locked(F, 1600+s, max(c,2e-4), max(p,4e-4))).result
    B=tc.BY_HAND_S; held=np.full(B.size,2.0); t=np.geomspace(5.,2e4,40); both=np.concatenate([t,2e4+t]); load=np.repeat([2.,0.],t.size)
    more="  temperature: {column: room, unit: degC}\n"
    for s in range(8):
        k=0.1*10**np.random.default_rng(s).uniform(0,1)
        yield "cnone", set(), lambda s=s: tc.readings(F,B,held,np.zeros(B.size),1700+s).result
        yield "creep", {"creep"}, lambda s=s,k=k: tc.readings(F,B,held,-2*k*2*tc.chain(B),1710+s).result
        yield "warmoff", {"thermal_drift"}, lambda s=s: tc.readings(F,both,load,-tc.warming(both),1720+s,noise=4e-6).result
        yield "warmstay", {"thermal_drift"}, lambda s=s: tc.readings(F,t,np.full(t.size,2.),-tc.warming(t),1730+s,noise=4e-6).result
        yield "creeptemp", {"creep","thermal_drift"}, lambda s=s: tc.readings(F,t,np.full(t.size,2.),-2*tc.chain(t)+2*tc.warming(t),1740+s,more,noise=4e-6).result
    ld=np.tile([0.2,-0.2,0.4,-0.4,0.6,-0.6],4); rows=np.arange(ld.size,dtype=float)
    for s in range(4):
        yield "dnone", set(), lambda s=s: close_loop(tp.DRIVE,[tp.by_hand("turning_points",rows,ld,np.zeros(ld.size),1800+s)])
        yield "dcomp", {"stiffness_error"}, lambda s=s: close_loop(tp.DRIVE,[tp.by_hand("turning_points",rows,ld,-(1+s)*1e-5*ld,1810+s)])
        yield "dplay", {"lash"}, lambda s=s: close_loop(tp.DRIVE,[tp.by_hand("turning_points",rows,ld,-(1+s)*5e-6*np.sign(ld),1820+s)])
from collections import Counter
tab={}
for kind,true,make in cases():
    if only and kind not in only: continue
    t0=time.process_time(); r=make(); cpu=time.process_time()-t0
    out={e.name for e in r.effects}; sets=[{e.name for e in g} for g in r.one_of]
    found=out|{n for g in sets for n in g}
    false=bool(out-true) or any(not(g&true) for g in sets)
    good=all(n in out or any(n in g for g in sets) for n in true)
    sc="false" if false else "right" if out==true and not sets else "set" if good else "missed"
    fl=r.errors
    tab.setdefault(kind,[Counter(),0.0]); tab[kind][0][sc]+=1; tab[kind][1]+=cpu
    print(kind,sc,r.verdict,sorted(out),[sorted(g) for g in sets],r.within_class[:40],"%.1f %.1f %.1f"%tuple(1e6*v for v in (fl.before.value,fl.after.value,fl.floor_rad)),"%.2f s"%cpu,flush=True)
for k,(c,s) in tab.items(): print("==",k,dict(c),"%.1f s"%s)
